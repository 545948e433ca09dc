#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mien/core/files.h"
#include "mien/model/model_file.h"
#include "mien/synthetic/imu/dataset_part.h"
#include "mien/train/takes_mix.h"
#include "mien/train/tasks.h"
#include "mien/train/trainer.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/train/toy_takes.h"

namespace mien::train::takes_task_test {
namespace {

using Json = nlohmann::json;
using MadeTask = Result<std::unique_ptr<Task>>;

class TakesTask : public testing::Test {
 protected:
  static MadeTask task_of(dataset::TrainingData data, const std::string& recipe) {
    return make_blendshape_task(*parse_recipe(recipe, "test"), std::move(data.train),
                                std::move(data.validation), "# rig");
  }
  [[nodiscard]] dataset::TrainingData both() const { return *synthetic::put_together(performed_, takes()); }
  [[nodiscard]] dataset::TrainingData takes() const { return *as_takes(taken_, 40); }

  Result<TrainReport> train_on(dataset::TrainingData data, const std::string& recipe, const std::string& name,
                               const std::string& from = "") const {
    MIEN_TRY_ASSIGN(const std::unique_ptr<Task> task, task_of(std::move(data), recipe));
    TrainOptions options{.out = folder_ / name, .force = true, .device = "cpu", .threads = 1};
    if (!from.empty()) options.from = folder_ / from;
    return train(*task, options, no_progress);
  }

  mien::test::Folder folder_;
  dataset::TrainingData performed_{.train = toy_data(0, 3), .validation = toy_data(10, 2)};
  dataset::TrainingData taken_{.train = toy_takes(0, 2), .validation = toy_takes(7, 1, 85)};
};

TEST_F(TakesTask, ValidatesOnBothByTheShare) {
  const auto task = task_of(both(), toy_recipe(1, "[takes]\nshare = 0.25\n"));
  ASSERT_TRUE(task) << task.error().message();
  const auto parts = (*task)->validation_parts(Random(1));
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].name, "virtual");
  EXPECT_EQ(parts[0].share, 0.75);
  EXPECT_EQ(parts[0].windows.windows, 12U) << "of 16";
  EXPECT_EQ(parts[1].name, "takes");
  EXPECT_EQ(parts[1].share, 0.25) << "though there are only two windows instead of four";
  EXPECT_EQ(parts[1].windows.windows, 2U);
  for (std::size_t i = kShapeOfTakes; i < parts[1].windows.clean.size(); i += face::kShapeCount)
    ASSERT_NEAR(parts[1].windows.clean[i], 0.8, 1e-5);
  for (std::size_t i = kShapeOfTakes; i < parts[0].windows.clean.size(); i += face::kShapeCount)
    ASSERT_NEAR(parts[0].windows.clean[i], -0.9, 1e-5);
}

TEST_F(TakesTask, HalfIsOfTakesUnlessTold) {
  EXPECT_EQ((*task_of(both(), toy_recipe(1)))->recipe().takes_share, 0.5);
  EXPECT_EQ((*task_of(takes(), toy_recipe(1)))->recipe().takes_share, 1) << "where there is nothing else";
  EXPECT_FALSE((*task_of(performed_, toy_recipe(1)))->recipe().takes_share);
}

TEST_F(TakesTask, TheShareIsPartOfWhatIsComparedAndGoneOnWith) {
  const auto hashes = [&](const std::string& share) {
    const auto task = task_of(both(), toy_recipe(1, "[takes]\nshare = " + share + "\n"));
    return (*task)->training_data().hash + ", " + (*task)->validation_data().hash;
  };
  EXPECT_EQ(hashes("0.25"), hashes("0.25"));
  EXPECT_NE(hashes("0.25"), hashes("0.5"));
}

TEST_F(TakesTask, ResultsTellOfBothAndNameNobody) {
  const auto report = train_on(both(), toy_causal_recipe(10, "[takes]\nshare = 0.25\n"), "m.safetensors");
  ASSERT_TRUE(report) << report.error().message();
  const Json results = Json::parse(model::read_model(folder_ / "m.safetensors")->results);
  const Json &validation = results["validation"], &parts = validation["parts"];
  EXPECT_NEAR(validation["score"].get<double>(),
              0.75 * parts["virtual"]["mse"].get<double>() + 0.25 * parts["takes"]["mse"].get<double>(),
              1e-9);
  EXPECT_EQ(parts["takes"]["windows"], 2);
  for (const char* profile : {"lab", "device", "takes"})
    EXPECT_GT(validation["profiles"][profile]["mean_pose_mse"].get<double>(), 0) << profile;
  const Json& takes = results["takes"];
  EXPECT_EQ(takes["share"], 0.25);
  EXPECT_EQ(takes["people"], 2);
  EXPECT_EQ(takes["validation_people"], 1);
  EXPECT_NEAR(takes["minutes"].get<double>(), 400.0 / 3600, 1e-9);
  EXPECT_NEAR(takes["validation_minutes"].get<double>(), 85.0 / 3600, 1e-9);
  EXPECT_EQ(takes["hash"].get<std::string>().size(), 64U);
  EXPECT_EQ(takes["one_person"], false);
  EXPECT_EQ(takes.size(), 7U) << "and nothing else";
}

TEST_F(TakesTask, ResultsSayThatOnePersonAloneIsNobodyElse) {
  dataset::TrainingData data = takes();
  const auto task = make_blendshape_task(*parse_recipe(toy_causal_recipe(2), "test"), data.train,
                                         data.validation, "# rig", true);
  ASSERT_TRUE(task) << task.error().message();
  const auto report =
      train(**task, {.out = folder_ / "m.safetensors", .device = "cpu", .threads = 1}, no_progress);
  ASSERT_TRUE(report) << report.error().message();
  const Json takes = Json::parse(report->results)["takes"];
  EXPECT_EQ(takes["one_person"], true);
  EXPECT_EQ(takes["validation_people"], 0);
  EXPECT_GT(takes["validation_minutes"].get<double>(), 0);
}

TEST_F(TakesTask, WithoutTakesResultsAreAsTheyWere) {
  ASSERT_TRUE(train_on(performed_, toy_causal_recipe(2), "m.safetensors"));
  const Json results = Json::parse(model::read_model(folder_ / "m.safetensors")->results);
  EXPECT_FALSE(results.contains("takes"));
  EXPECT_FALSE(results["validation"].contains("parts"));
  EXPECT_FALSE(results["validation"]["profiles"].contains("takes"));
}

TEST_F(TakesTask, AreLearntAlone) {
  for (const auto& recipe : {toy_causal_recipe(150), toy_recipe(250)}) {
    const auto report = train_on(takes(), recipe, "m.safetensors");
    ASSERT_TRUE(report) << report.error().message();
    const auto model = model::read_model(folder_ / "m.safetensors");
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ(model->ridge_for("lab"), nullptr);
    EXPECT_NE(model->ridge_for("device"), nullptr);
    EXPECT_FALSE(model->skin) << "takes tell of no skin";
    const Json results = Json::parse(model->results);
    EXPECT_EQ(results["takes"]["share"], 1);
    EXPECT_FALSE(results["validation"].contains("parts"));
    EXPECT_LT(results["validation"]["mse"].get<double>(),
              results["validation"]["profiles"]["takes"]["mean_pose_mse"].get<double>());
  }
}

TEST_F(TakesTask, KnownSkinsAreOfPerformersAlone) {
  const std::string recipe = toy_causal_recipe(1, "[augmentation]\nknown_skin = 1\n");
  EXPECT_TRUE(task_of(takes(), recipe)) << "nobody's is known, and nobody is refused";
  EXPECT_EQ(task_of(both(), recipe).error().code, ErrorCode::mismatch) << "performers' must be";
  const std::size_t slopes = 3 * performed_.train.sensors.size() * face::kShapeCount;
  for (dataset::Dataset* data : {&performed_.train, &performed_.validation}) {
    data->standard_slopes.assign(slopes, 0.1F);
    for (dataset::Sequence& s : data->sequences) s.slopes = data->standard_slopes;
  }
  EXPECT_TRUE(task_of(both(), recipe));

  // Who goes on with takes alone keeps the skin that the network was made for.
  ASSERT_TRUE(train_on(performed_, toy_causal_recipe(1), "first.safetensors"));
  ASSERT_TRUE(train_on(takes(), recipe, "second.safetensors", "first.safetensors"));
  const auto first = model::read_model(folder_ / "first.safetensors"),
             second = model::read_model(folder_ / "second.safetensors");
  ASSERT_TRUE(second->skin);
  EXPECT_EQ(second->skin->standard, first->skin->standard);
  EXPECT_EQ(second->skin->covariance, first->skin->covariance);
  EXPECT_EQ(second->normalisation.mean, first->normalisation.mean);
}

TEST_F(TakesTask, ResumesToTheSameBits) {
  const std::string recipe = toy_causal_recipe(20, "[takes]\nshare = 0.3\n");
  ASSERT_TRUE(train_on(both(), recipe, "straight.safetensors"));
  std::size_t calls = 0;
  const auto task = task_of(both(), recipe);
  TrainOptions options{.out = folder_ / "resumed.safetensors", .device = "cpu", .threads = 1};
  ASSERT_FALSE(train(**task, options, [&](double, std::string_view) { return ++calls < 8; }));
  options.resume = true;
  ASSERT_TRUE(train(**task, options, no_progress));
  EXPECT_EQ(model::read_model(folder_ / "straight.safetensors")->network,
            model::read_model(folder_ / "resumed.safetensors")->network);
}

TEST_F(TakesTask, WeightsAreKeptByPerformersWhereNobodyElseIsHeldOut) {
  taken_.validation = {};
  const auto task = task_of(both(), toy_recipe(1));
  ASSERT_TRUE(task) << task.error().message();
  const auto parts = (*task)->validation_parts(Random(1));
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].share, 1);
  EXPECT_EQ(parts[0].windows.windows, 16U);
}

TEST_F(TakesTask, RefusesWhatCannotBeTrained) {
  const auto no_takes = task_of(performed_, toy_recipe(1, "[takes]\nshare = 0.5\n"));
  EXPECT_EQ(no_takes.error().code, ErrorCode::bad_usage);
  const auto no_performers = task_of(takes(), toy_recipe(1, "[takes]\nshare = 0.5\n"));
  EXPECT_EQ(no_performers.error().code, ErrorCode::bad_usage);
  taken_.validation = {};
  const auto nobody_held_out = task_of(takes(), toy_recipe(1));
  ASSERT_FALSE(nobody_held_out);
  EXPECT_EQ(nobody_held_out.error().code, ErrorCode::bad_usage);
  EXPECT_NE(nobody_held_out.error().message().find("--splits"), std::string::npos);
  taken_.validation = toy_takes(1, 1);
  EXPECT_EQ(task_of(takes(), toy_recipe(1)).error().code, ErrorCode::mismatch) << "one person in both";
}

TEST_F(TakesTask, GoOnFromTheShippedModel) {
  const auto shipped = model::read_model(project_path("models/live.safetensors"));
  ASSERT_TRUE(shipped) << shipped.error().message();
  Recipe recipe =
      *parse_recipe(*read_text(project_path("models/recipes/live_takes.toml")), "live_takes.toml");
  EXPECT_EQ(recipe.takes_share, 0.5);
  EXPECT_EQ(recipe.architecture.window, shipped->architecture.window);
  recipe.steps = recipe.every_steps = 1;
  recipe.batch = recipe.windows = 2;
  recipe.takes_share.reset();
  const auto people = [&](std::uint32_t first) {
    dataset::Dataset data{.sensors = shipped->features.sensors, .standard_slopes = {}, .sequences = {}};
    for (const dataset::Sequence& toy : toy_takes(first, 2, 250).sequences) {
      dataset::Sequence& s = data.sequences.emplace_back(toy);
      const std::size_t n = data.sensors.size();
      s.values.clear();
      for (std::size_t f = 0; f < s.frames; ++f)
        for (std::size_t sensor = 0; sensor < n; ++sensor)
          s.values.insert(s.values.end(), toy.values.begin() + static_cast<std::ptrdiff_t>(f * 14),
                          toy.values.begin() + static_cast<std::ptrdiff_t>(f * 14 + 7));
      s.present.assign(s.frames * 2 * n, 1);
    }
    return data;
  };
  const auto data = as_takes({.train = people(0), .validation = people(2)}, recipe.architecture.window);
  ASSERT_TRUE(data) << data.error().message();
  const auto task = make_blendshape_task(recipe, data->train, data->validation, shipped->rig);
  ASSERT_TRUE(task) << task.error().message();
  const auto report = train(**task,
                            {.out = folder_ / "mine.safetensors",
                             .from = project_path("models/live.safetensors"),
                             .device = "cpu",
                             .threads = 1},
                            no_progress);
  ASSERT_TRUE(report) << report.error().message();
  const auto mine = model::read_model(folder_ / "mine.safetensors");
  ASSERT_TRUE(mine) << mine.error().message();
  EXPECT_EQ(mine->normalisation.scale, shipped->normalisation.scale);
  ASSERT_TRUE(mine->skin);
  EXPECT_EQ(mine->skin->standard, shipped->skin->standard);
  double apart = 0;
  for (std::size_t t = 0; t < mine->network.size(); ++t)
    for (std::size_t i = 0; i < mine->network[t].values.size(); ++i)
      apart = std::max<double>(apart, std::abs(mine->network[t].values[i] - shipped->network[t].values[i]));
  EXPECT_GT(apart, 0) << "it has learnt";
  EXPECT_LT(apart, 0.01) << "and begun with the shipped one";
}

}  // namespace
}  // namespace mien::train::takes_task_test
