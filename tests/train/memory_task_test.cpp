#include "mien/train/tasks.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/headset/answer.h"
#include "mien/headset/headset_model.h"
#include "mien/train/diffusion.h"
#include "mien/train/network.h"
#include "mien/train/trainer.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/train/toy_films.h"

namespace mien::train::memory_task_test {
namespace {

using test::toy_films;

Recipe recipe_of(std::size_t steps, const char* architecture = "causal") {
  return *parse_recipe(fmt::format(R"(
seed = 3
[network]
architecture = "{}"
d_model = 32
window = 32
dropout = 0
[optimiser]
learning_rate = 3e-3
loss = "l2"
precision = "fp32"
batch = 8
warm_up_steps = 10
ema = 0.9
[validation]
windows = 8
every_steps = 1000
[budget]
steps = {}
)",
                                   architecture, steps),
                       "test");
}

/// A network of pictures that has learnt nothing; what it finds still tells bars apart.
headset::ViewsFile views() {
  headset::ViewsFile file;
  file.architecture = model::named_architecture("views", 1).value();
  file.architecture.side = test::kFilmSide;
  file.architecture.widths = {8, 16};
  file.architecture.layers = 2;
  file.architecture.features = 16;
  file.architecture.d_model = 32;
  file.architecture.outputs = headset::kAnswerOutputs;
  file.architecture.condition = model::views_condition(test::kFilmSide);
  file.network = to_tensors(file.architecture, fresh_parameters(file.architecture, 5, false, torch::kCPU));
  file.mean_answer.assign(headset::kAnswerOutputs, -1.0F);
  file.mean_answer[face::shape("jawOpen")] = 0;
  file.mean_answer[face::shape("eyeBlink_L")] = 0;
  return file;
}

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  return rig;
}

Result<std::unique_ptr<Task>> task_of(const std::filesystem::path& folder, std::size_t steps = 1) {
  return make_memory_task(recipe_of(steps), toy_films(folder, 10), views(), rig(), no_progress);
}

TEST(MemoryTask, LearnsAToyAndToJudgeItself) {
  const mien::test::Folder folder;
  const auto task = task_of(folder.path(), 250);
  ASSERT_TRUE(task) << task.error().message();
  const auto report =
      train(**task, {.out = folder / "toy.safetensors", .device = "cpu", .threads = 1}, no_progress);
  ASSERT_TRUE(report) << report.error().message();
  const auto results = nlohmann::json::parse(report->results)["headset"];
  // The network of pictures is a random one, all of whose answers are wrong.
  EXPECT_LT(results["mse"].get<double>(), 0.1 * results["moment_mse"].get<double>()) << results;
  EXPECT_TRUE(results["judgements"][0]["ece"].is_null()) << "one wearer alone cannot be judged by others";
  EXPECT_GT(results["mirrored_eye"]["auc"].get<double>(), 0.9);
  EXPECT_GT(results["mirrored_eye"]["found"].get<double>(),
            results["mirrored_eye"]["false_alarms"].get<double>());

  const auto file = headset::read_views_file(folder / "toy.safetensors");
  ASSERT_TRUE(file) << file.error().message();
  ASSERT_TRUE(file->memory);
  EXPECT_EQ(file->memory->architecture.condition, headset::moment_condition(16));
  EXPECT_EQ(file->memory->mirrored_eye.weight.size(), 16U);
  const auto model = headset::HeadsetModel::create(*file);
  ASSERT_TRUE(model) << model.error().message();
  ASSERT_NE((*model)->memory(), nullptr);
  // The network of pictures is the one it was given.
  EXPECT_EQ(file->network.front().values, views().network.front().values);
}

TEST(MemoryTask, BatchesFollowTheirStream) {
  const mien::test::Folder folder;
  const auto task = task_of(folder.path());
  ASSERT_TRUE(task) << task.error().message();
  const Batch one = (*task)->random_batch(4, Random(1)), two = (*task)->random_batch(4, Random(1));
  EXPECT_EQ(one.condition, two.condition);
  EXPECT_EQ(one.windows, 4u);
  EXPECT_EQ(one.clean.size(), 4 * 32 * headset::kMemoryOutputs);
  EXPECT_EQ(one.condition.size(), 4 * 32 * headset::moment_condition(16));
  EXPECT_NE(one.condition, (*task)->random_batch(4, Random(2)).condition);
  // Half of what is trained on is mirrored, so the other lid moves too; in validation it does not.
  const auto most = [](const Batch& batch, std::size_t output) {
    float largest = -1;
    for (std::size_t at = output; at < batch.clean.size(); at += headset::kMemoryOutputs)
      largest = std::max(largest, batch.clean[at]);
    return largest;
  };
  const Batch many = (*task)->random_batch(16, Random(3)), validation = (*task)->validation_batch(Random(1));
  EXPECT_GT(most(many, face::shape("eyeBlink_R")), 0.5F);
  EXPECT_EQ(most(validation, face::shape("eyeBlink_R")), -1);
}

TEST(MemoryTask, CamerasAreAwayNowAndThenInTraining) {
  const mien::test::Folder folder;
  const auto task = task_of(folder.path());
  ASSERT_TRUE(task) << task.error().message();
  const std::size_t each = headset::moment_condition(16);
  const auto missing = [&](const Batch& batch) {
    std::size_t count = 0;
    for (std::size_t at = 0; at < batch.condition.size(); at += each)
      for (std::size_t v = 0; v < model::kViews; ++v)
        count += batch.condition[at + headset::moment_answer(16) - 1 - model::kViews + v] == 0 ? 1 : 0;
    return count;
  };
  EXPECT_GT(missing((*task)->random_batch(32, Random(1))), 0U);
  EXPECT_EQ(missing((*task)->validation_batch(Random(1))), 0U);
}

TEST(MemoryTask, RefusesWhatDoesNotFit) {
  const mien::test::Folder folder;
  EXPECT_FALSE(
      make_memory_task(recipe_of(1, "light"), toy_films(folder.path(), 10), views(), rig(), no_progress));
  headset::ViewsFile other = views();
  other.architecture.side = 48;
  EXPECT_FALSE(make_memory_task(recipe_of(1), toy_films(folder.path(), 10), other, rig(), no_progress));
  Recipe longer = recipe_of(1);
  longer.architecture.window = 200;
  EXPECT_FALSE(make_memory_task(longer, toy_films(folder.path(), 10), views(), rig(), no_progress));
}

TEST(Loss, GazeWeighsAsMuchAsIsAsked) {
  Recipe recipe = recipe_of(1);
  recipe.judgements.clear();
  recipe.difference_weight = 0;
  const DeviceBatch batch{.condition = {},
                          .clean = torch::zeros({1, 1, 2}),
                          .level = torch::zeros({1}, torch::kLong),
                          .held = torch::zeros({1}, torch::kLong)};
  const auto loss = [&](std::vector<float> answers) {
    return loss_of(recipe, torch::tensor(answers).view({1, 1, 2}), batch).item<double>();
  };
  recipe.gaze_outputs = {1};
  EXPECT_EQ(loss({1, 0}), loss({0, 1}));
  recipe.gaze_weight = 10;
  EXPECT_FLOAT_EQ(static_cast<float>(loss({0, 1})), static_cast<float>(10 * loss({1, 0})));
}

TEST(Loss, AMemoryAddsAsMuchAsItDoubts) {
  // One frame: an answer that is asked for as 1, of which the moment says 0.2 and the memory would add 0.8.
  const auto error = [](float logit) {
    Recipe recipe = recipe_of(1);
    recipe.difference_weight = 0;
    recipe.judgements = {{.outputs = {0}, .most_error = 0.1}};
    recipe.addition = Addition{.to = 1, .doubted_by = {0}};
    recipe.architecture = {.kind = model::NetworkKind::causal};
    recipe.architecture.condition = recipe.architecture.d_model = 2;
    recipe.architecture.layers = 0;
    recipe.architecture.outputs = 2;
    const Parameters nothing_but_biases = {torch::zeros({2, 2}), torch::zeros({2}), torch::zeros({2, 2}),
                                           torch::tensor({0.8F, logit})};
    const torch::Tensor condition = torch::tensor({9.0F, 0.2F}).view({1, 1, 2});
    const torch::Tensor answer = answer_at_once(recipe, nothing_but_biases, condition, {});
    EXPECT_FLOAT_EQ(answer[0][0][1].item<float>(), logit) << "a judgement is the memory's alone";
    return std::abs(1 - answer[0][0][0].item<float>());
  };
  EXPECT_NEAR(error(-20), 0, 1e-5);
  EXPECT_NEAR(error(0), 0.4, 1e-5);
  EXPECT_NEAR(error(20), 0.8, 1e-5);
}

TEST(Loss, ChangesOfQuickAnswersAreNotAskedFor) {
  Recipe recipe = recipe_of(1);
  recipe.judgements.clear();
  recipe.difference_weight = 5;
  const DeviceBatch batch{.condition = {},
                          .clean = torch::zeros({1, 3, 2}),
                          .level = torch::zeros({1}, torch::kLong),
                          .held = torch::zeros({1}, torch::kLong)};
  const auto loss = [&](std::vector<float> answers) {
    return loss_of(recipe, torch::tensor(answers).view({1, 3, 2}), batch).item<double>();
  };
  const std::vector<float> first_is_rough = {0, 0, 1, 0, 0, 0}, second_is_rough = {0, 0, 0, 1, 0, 0};
  EXPECT_EQ(loss(first_is_rough), loss(second_is_rough));
  recipe.quick_outputs = {1};
  EXPECT_GT(loss(first_is_rough), 2 * loss(second_is_rough));
}

TEST(Loss, AJudgementIsAskedWhetherTheAnswerIsRight) {
  Recipe recipe = recipe_of(1);
  recipe.judgements = {{.outputs = {0, 1}, .most_error = 0.1}};
  // Two frames: the first right, the second wrong; then the logit.
  const auto predicted = [](float first, float second) {
    return torch::tensor({0.05F, 0.0F, first, 0.5F, 0.0F, second}).view({1, 2, 3});
  };
  const auto asked = [](float first, float second) {
    return torch::tensor({0.0F, 0.0F, first, 0.0F, 0.0F, second}).view({1, 2, 3});
  };
  const DeviceBatch batch{.condition = {},
                          .clean = asked(1, 1),
                          .level = torch::zeros({1}, torch::kLong),
                          .held = torch::zeros({1}, torch::kLong)};
  const double well = loss_of(recipe, predicted(3, -3), batch).item<double>(),
               badly = loss_of(recipe, predicted(-3, 3), batch).item<double>();
  EXPECT_LT(well, badly);
  // What nobody knows cannot be right.
  DeviceBatch unknown = batch;
  unknown.clean = asked(1, 1);
  unknown.clean.narrow(2, 0, 2).fill_(std::nanf(""));
  EXPECT_LT(loss_of(recipe, predicted(-3, -3), unknown).item<double>(),
            loss_of(recipe, predicted(3, 3), unknown).item<double>());
  // Nor can what nobody sees.
  DeviceBatch hidden = batch;
  hidden.clean = asked(0, 0);
  EXPECT_LT(loss_of(recipe, predicted(-3, -3), hidden).item<double>(),
            loss_of(recipe, predicted(3, -3), hidden).item<double>());
}

}  // namespace
}  // namespace mien::train::memory_task_test
