#include "mien/train/trainer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mien/core/files.h"
#include "mien/model/model_file.h"
#include "mien/train/parity.h"
#include "mien/train/tasks.h"
#include "tests/folder.h"
#include "tests/model/random_network.h"
#include "tests/train/toy_data.h"

namespace mien::train::trainer_test {
namespace {

namespace fs = std::filesystem;

/// A curve's rows without their second cell.
std::string without_seconds(const std::string& curve) {
  std::string out;
  std::istringstream lines(curve);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t step = line.find(',');
    out += line.substr(0, step) + line.substr(line.find(',', step + 1)) + "\n";
  }
  return out;
}

class Trainer : public testing::Test {
 protected:
  Result<TrainReport> run(const std::string& name, std::size_t steps, bool resume = false,
                          const Progress& progress = no_progress, const std::string& more = "",
                          bool force = false) const {
    return run_recipe(toy_recipe(steps, more), name, resume, progress, force);
  }
  Result<TrainReport> run_recipe(const std::string& recipe, const std::string& name, bool resume = false,
                                 const Progress& progress = no_progress, bool force = false) const {
    MIEN_TRY_ASSIGN(const std::unique_ptr<Task> task,
                    make_blendshape_task(*parse_recipe(recipe, "test"), training_, validation_, "# rig"));
    return train(*task,
                 {.out = folder_ / name, .resume = resume, .force = force, .device = "cpu", .threads = 1},
                 progress);
  }

  mien::test::Folder folder_;
  dataset::Dataset training_ = toy_data(0, 4), validation_ = toy_data(10, 2);
};

TEST_F(Trainer, LearnsAToyAndLeavesNoSeam) {
  const auto report = run("toy.safetensors", 500);
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_TRUE(report->replaced);
  const auto model = model::read_model(folder_ / "toy.safetensors");
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->rig, "# rig");
  EXPECT_EQ(model->recipe, toy_recipe(500));
  EXPECT_EQ(model->shapes.size(), 53U);
  ASSERT_NE(model->ridge_for("lab"), nullptr);
  ASSERT_NE(model->ridge_for("device"), nullptr);
  EXPECT_LT(measure_parity(*model)->largest_difference, kParityLimit);

  const auto results = nlohmann::json::parse(model->results);
  const double mean_pose = results["validation"]["profiles"]["lab"]["mean_pose_mse"];
  EXPECT_LT(results["validation"]["mse"].get<double>(), 0.45 * mean_pose);
  EXPECT_LT(results["validation"]["profiles"]["lab"]["ridge_mse"].get<double>(), mean_pose);
  ASSERT_EQ(results["samplers"].size(), 8U);
  for (const auto& sampler : results["samplers"])
    if (sampler["steps"] == model->sampler.steps && sampler["first_noise"] == model->sampler.first_noise &&
        (sampler["hold"] == "clean") == (model->sampler.hold == model::OverlapHold::clean)) {
      EXPECT_LE(sampler["seam_ratio"].get<double>(), 1.2);
      EXPECT_LT(sampler["mse"].get<double>(), 0.45 * mean_pose);
    }
  EXPECT_FALSE(fs::exists(folder_ / "toy.safetensors.checkpoint"));
  const auto curve = read_text(folder_ / "toy.csv");
  ASSERT_TRUE(curve);
  EXPECT_EQ(std::count(curve->begin(), curve->end(), '\n'), 51);
}

TEST_F(Trainer, ACausalNetworkLearnsAToy) {
  const std::string recipe =
      toy_causal_recipe(300, "[augmentation]\nstretch_loss = 0.05\nheld_readings = 0.2\n");
  const auto report = run_recipe(recipe, "toy.safetensors");
  ASSERT_TRUE(report) << report.error().message();
  const auto model = model::read_model(folder_ / "toy.safetensors");
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->architecture.kind, model::NetworkKind::causal);
  ASSERT_NE(model->ridge_for("device"), nullptr);
  const auto parity = measure_parity(*model);
  ASSERT_TRUE(parity);
  EXPECT_EQ(parity->calls, 40U);
  EXPECT_LT(parity->largest_difference, kParityLimit);

  const auto results = nlohmann::json::parse(model->results);
  const double mean_pose = results["validation"]["profiles"]["lab"]["mean_pose_mse"];
  EXPECT_LT(results["validation"]["mse"].get<double>(), 0.3 * mean_pose);
  EXPECT_LT(results["causal"]["mse"].get<double>(), 0.3 * mean_pose);
  EXPECT_GT(results["causal"]["jitter_ratio"].get<double>(), 0);
  EXPECT_FALSE(results.contains("samplers"));
}

TEST_F(Trainer, GoesOnFromAnotherModelAndLearnsKnownSkins) {
  ASSERT_TRUE(run_recipe(toy_causal_recipe(200), "first.safetensors"));
  // Both people's sensors are as the standard's, so what is known of their skin changes nothing of the toy.
  const std::size_t slopes = 3 * training_.sensors.size() * face::kShapeCount;
  for (dataset::Dataset* data : {&training_, &validation_}) {
    data->standard_slopes.assign(slopes, 0.1F);
    for (dataset::Sequence& s : data->sequences) s.slopes = data->standard_slopes;
  }
  const std::string recipe = toy_causal_recipe(3, "[augmentation]\nknown_skin = 1\nskin_gain_error = 0\n");
  const auto go_on = [&](const std::string& from) -> Result<TrainReport> {
    MIEN_TRY_ASSIGN(const std::unique_ptr<Task> task,
                    make_blendshape_task(*parse_recipe(recipe, "test"), training_, validation_, "# rig"));
    return train(*task,
                 {.out = folder_ / "second.safetensors", .from = folder_ / from, .force = true, .threads = 1},
                 no_progress);
  };
  const auto report = go_on("first.safetensors");
  ASSERT_TRUE(report) << report.error().message();
  const auto model = model::read_model(folder_ / "second.safetensors");
  ASSERT_TRUE(model) << model.error().message();
  ASSERT_TRUE(model->skin);
  EXPECT_EQ(model->skin->standard, training_.standard_slopes);
  EXPECT_TRUE(model->skin->wearer.empty());
  EXPECT_NEAR(model->skin->covariance[0], 0.125, 0.05) << "a sine from 0 to 1";
  const auto results = nlohmann::json::parse(model->results);
  const double mean_pose = results["validation"]["profiles"]["lab"]["mean_pose_mse"];
  EXPECT_LT(results["validation"]["mse"].get<double>(), 0.4 * mean_pose) << "three steps alone learn nothing";

  ASSERT_TRUE(run("window.safetensors", 2));
  const auto refused = go_on("window.safetensors");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
  training_.sequences.front().slopes.clear();
  EXPECT_EQ(go_on("first.safetensors").error().code, ErrorCode::mismatch) << "a skin that nobody knows";
}

TEST_F(Trainer, ACausalNetworkResumesToTheSameBits) {
  ASSERT_TRUE(run_recipe(toy_causal_recipe(30), "straight.safetensors"));
  std::size_t calls = 0;
  ASSERT_FALSE(run_recipe(toy_causal_recipe(30), "resumed.safetensors", false,
                          [&](double, std::string_view) { return ++calls < 13; }));
  ASSERT_TRUE(run_recipe(toy_causal_recipe(30), "resumed.safetensors", true));
  EXPECT_EQ(model::read_model(folder_ / "straight.safetensors")->network,
            model::read_model(folder_ / "resumed.safetensors")->network);
}

TEST_F(Trainer, StoppedAndResumedEndsWithTheSameBits) {
  ASSERT_TRUE(run("straight.safetensors", 30));
  // Between two validations, at one, and at the last step.
  for (const std::size_t step : {13U, 20U, 30U}) {
    std::size_t calls = 0;
    const auto stopped =
        run("resumed.safetensors", 30, false, [&](double, std::string_view) { return ++calls < step; });
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
    EXPECT_FALSE(fs::exists(folder_ / "resumed.safetensors"));
    ASSERT_FALSE(run("resumed.safetensors", 30)) << "an unfinished run is not dropped in silence";
    const auto resumed = run("resumed.safetensors", 30, true);
    ASSERT_TRUE(resumed) << resumed.error().message();
    EXPECT_EQ(model::read_model(folder_ / "straight.safetensors")->network,
              model::read_model(folder_ / "resumed.safetensors")->network);
    EXPECT_EQ(without_seconds(*read_text(folder_ / "straight.csv")),
              without_seconds(*read_text(folder_ / "resumed.csv")));
    fs::remove(folder_ / "resumed.safetensors");
  }
}

TEST_F(Trainer, KilledAtACheckpointEndsWithTheSameBits) {
  ASSERT_TRUE(run("straight.safetensors", 30));
  // A run that is killed leaves the checkpoint of its last validation; take it away while it runs on.
  const fs::path checkpoint = folder_ / "killed.safetensors.checkpoint", kept = folder_ / "kept";
  ASSERT_TRUE(run("killed.safetensors", 30, false, [&](double, std::string_view what) {
    if (what.starts_with("step 27")) fs::copy_file(checkpoint, kept);
    return true;
  }));
  ASSERT_TRUE(fs::exists(kept));
  fs::remove(folder_ / "killed.safetensors");
  fs::rename(kept, checkpoint);
  ASSERT_TRUE(run("killed.safetensors", 30, true));
  EXPECT_EQ(model::read_model(folder_ / "straight.safetensors")->network,
            model::read_model(folder_ / "killed.safetensors")->network);
}

TEST_F(Trainer, KilledBehindItsLastCheckpointLeavesTheWholeCurve) {
  const fs::path out = folder_ / "m.safetensors", checkpoint = folder_ / "m.safetensors.checkpoint",
                 curve = folder_ / "m.csv", kept = folder_ / "kept";
  // The last step's stands until the model is written.
  ASSERT_TRUE(run("m.safetensors", 30, false, [&](double, std::string_view what) {
    if (!what.starts_with("step ") && fs::exists(checkpoint))
      fs::copy_file(checkpoint, kept, fs::copy_options::overwrite_existing);
    return true;
  }));
  ASSERT_TRUE(fs::exists(kept));
  const std::string whole = *read_text(curve);
  const auto straight = model::read_model(out)->network;
  const std::string without_last_row = whole.substr(0, whole.rfind('\n', whole.size() - 2) + 1);
  for (const std::string& left : {std::string(), without_last_row}) {
    fs::remove(out);
    fs::remove(curve);
    fs::copy_file(kept, checkpoint);
    if (!left.empty()) {
      ASSERT_TRUE(write_file(curve, left));
    }
    ASSERT_TRUE(run("m.safetensors", 30, true));
    EXPECT_EQ(*read_text(curve), whole);
    EXPECT_EQ(model::read_model(out)->network, straight);
  }
}

TEST_F(Trainer, ABetterModelStays) {
  ASSERT_TRUE(run("m.safetensors", 80));
  const auto before = read_file(folder_ / "m.safetensors");
  const auto worse = run("m.safetensors", 10);
  ASSERT_TRUE(worse) << worse.error().message();
  EXPECT_FALSE(worse->replaced);
  EXPECT_EQ(*read_file(folder_ / "m.safetensors"), *before);
  EXPECT_TRUE(fs::exists(folder_ / "m.worse.safetensors"));
  const auto better = run("m.safetensors", 200);
  ASSERT_TRUE(better);
  EXPECT_TRUE(better->replaced);
  EXPECT_NE(*read_file(folder_ / "m.safetensors"), *before);
}

TEST_F(Trainer, AModelOfOtherDataIsNotReplaced) {
  ASSERT_TRUE(run("m.safetensors", 10));
  validation_ = toy_data(20, 2);
  const auto other = run("m.safetensors", 10);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::mismatch);
  EXPECT_TRUE(run("m.safetensors", 10, false, no_progress, "", true)) << "--force replaces it";
}

TEST_F(Trainer, ACheckpointOfAnotherRunIsRefused) {
  ASSERT_FALSE(
      run("m.safetensors", 30, false, [n = 0](double, std::string_view) mutable { return ++n < 5; }));
  const auto other = run("m.safetensors", 40, true);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::mismatch);
  // A checkpoint that is cut short is one clear error, and is not trained on.
  const fs::path path = folder_ / "m.safetensors.checkpoint";
  fs::resize_file(path, fs::file_size(path) / 2);
  EXPECT_FALSE(run("m.safetensors", 30, true));
}

TEST_F(Trainer, AllItsOptionsTrain) {
  const auto report =
      run("m.safetensors", 20, false, no_progress,
          "[noise]\nt_bias = 1\nt_weight = 0.5\nheld_overlap = 0.3\n[augmentation]\nsensor_loss = 0.2\n");
  ASSERT_TRUE(report) << report.error().message();
}

TEST_F(Trainer, RefusesWhatCannotBeTrained) {
  const Recipe recipe = *parse_recipe(toy_recipe(10), "test");
  EXPECT_FALSE(make_blendshape_task(recipe, {}, validation_, ""));
  EXPECT_FALSE(make_blendshape_task(recipe, training_, training_, "")) << "the same people on both sides";
  EXPECT_FALSE(make_blendshape_task(recipe, toy_data(0, 2, 39), validation_, ""))
      << "no take as long as a window";
  const auto task = make_blendshape_task(recipe, training_, validation_, "");
  ASSERT_TRUE(task) << task.error().message();
  const TrainOptions nowhere{.out = folder_ / "m.safetensors", .device = "warp-drive", .threads = 1};
  EXPECT_FALSE(train(**task, nowhere, no_progress));
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST(Parity, TheRunTimeAgreesWithLibtorch) {
  for (const char* name : {"light", "faithful", "causal"}) {
    model::ModelFile model;
    model.architecture = *model::named_architecture(name, 99);
    model.network = model::random_network(model.architecture, 5);
    const auto parity = measure_parity(model);
    ASSERT_TRUE(parity);
    EXPECT_LT(parity->largest_difference, kParityLimit) << name;
    EXPECT_GT(parity->largest_difference, 0.0);
  }
}

}  // namespace
}  // namespace mien::train::trainer_test
