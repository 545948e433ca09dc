#include "mien/train/tasks.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/headset/answer.h"
#include "mien/model/views_network.h"
#include "mien/train/diffusion.h"
#include "mien/train/network.h"
#include "mien/train/trainer.h"
#include "mien/train/view_augmentation.h"
#include "mien/train/view_obstacle.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/train/toy_films.h"

namespace mien::train::views_task_test {
namespace {

using test::toy_films;
constexpr std::size_t kSide = test::kFilmSide;

Recipe recipe_of(std::size_t steps) {
  return *parse_recipe(fmt::format(R"(
seed = 3
[network]
architecture = "views"
side = {}
widths = [8, 16]
features = 16
d_model = 32
window = 4
dropout = 0
[optimiser]
learning_rate = 3e-3
loss = "l2"
precision = "fp32"
batch = 4
warm_up_steps = 10
ema = 0.9
[validation]
windows = 64
every_steps = 1000
score = "loss"
[budget]
steps = {}
)",
                                   kSide, steps),
                       "test");
}

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  return rig;
}

TEST(ViewsTask, LearnsAToyThatCanBeSeen) {
  const mien::test::Folder folder;
  const auto task = make_views_task(recipe_of(250), toy_films(folder.path()), rig(), "rig text");
  ASSERT_TRUE(task) << task.error().message();
  const auto report =
      train(**task, {.out = folder / "toy.safetensors", .device = "cpu", .threads = 1}, no_progress);
  ASSERT_TRUE(report) << report.error().message();
  const auto results = nlohmann::json::parse(report->results)["headset"];
  EXPECT_LT(results["mse"].get<double>(), 0.4 * results["mean_pose_mse"].get<double>());

  const auto file = headset::read_views_file(folder / "toy.safetensors");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->rig, "rig text");
  EXPECT_EQ(file->mean_answer.size(), headset::kAnswerOutputs);
}

TEST(ViewsTask, TheRunTimeAnswersAsLibtorchDoes) {
  const Recipe recipe = recipe_of(1);
  model::Architecture architecture = recipe.architecture;
  architecture.outputs = headset::kAnswerOutputs;
  const Parameters parameters = fresh_parameters(architecture, 5, false, torch::kCPU);
  const auto runs = model::ViewsNetwork::create(architecture, to_tensors(architecture, parameters));
  ASSERT_TRUE(runs) << runs.error().message();
  model::ViewsNetwork::Workspace memory(*runs);
  Random random(9);
  // A moment at rest, then others; with views that are missing, and where rest is not known.
  const std::size_t found = 4 * architecture.features;
  for (const bool known : {true, false}) {
    const std::vector<std::array<bool, 4>> present = {
        {true, true, false, true}, {true, true, true, true}, {true, false, false, true}, {}};
    std::vector<float> condition(present.size() * architecture.condition);
    std::vector<std::vector<float>> features;
    for (std::size_t m = 0; m < present.size(); ++m) {
      const auto moment = std::span(condition).subspan(m * architecture.condition, architecture.condition);
      for (float& value : moment.first(4 * kSide * kSide)) value = static_cast<float>(random.uniform());
      for (std::size_t v = 0; v < 4; ++v) moment[4 * kSide * kSide + v] = present[m][v] ? 1 : 0;
      moment.back() = known ? 1 : 0;
      runs->find(moment.first(4 * kSide * kSide), present[m], memory, features.emplace_back(found));
    }
    const torch::Tensor wanted =
        predict_at_once(architecture, parameters, torch::tensor(condition).view({1, 4, -1}), {})[0];
    for (std::size_t m = 0; m < present.size(); ++m) {
      std::vector<float> differences(found), answer(architecture.outputs);
      for (std::size_t i = 0; i < found; ++i)
        if (const std::size_t v = i / architecture.features; known && present[m][v] && present[0][v])
          differences[i] = features[m][i] - features[0][i];
      runs->answer(features[m], differences, memory, answer);
      for (std::size_t i = 0; i < answer.size(); ++i)
        EXPECT_NEAR(answer[i],
                    wanted[static_cast<std::int64_t>(m)][static_cast<std::int64_t>(i)].item<float>(), 1e-4);
    }
  }
}

TEST(ViewsTask, FoldedWeightsAnswerAsBatchNormalisationDid) {
  model::Architecture architecture = recipe_of(1).architecture;
  architecture.outputs = headset::kAnswerOutputs;
  const Parameters parameters = fresh_parameters(architecture, 5, false, torch::kCPU);
  torch::manual_seed(1);
  const torch::Tensor condition =
      torch::rand({6, 4, static_cast<std::int64_t>(architecture.condition)}) * 3 + 0.5;
  const torch::Tensor normalised = predict_at_once(architecture, parameters, condition, {.batch_norm = true});
  const Parameters folded = fold_batch_norm(architecture, parameters, condition);
  const auto furthest = [&](const Parameters& weights) {
    return (predict_at_once(architecture, weights, condition, {}) - normalised).abs().max().item<float>();
  };
  EXPECT_LT(furthest(folded), 1e-3F);
  EXPECT_GT(furthest(parameters), 0.1F);
}

TEST(ViewsTask, BatchesFollowTheirStream) {
  const mien::test::Folder folder;
  const auto task = make_views_task(recipe_of(1), toy_films(folder.path()), rig(), "");
  ASSERT_TRUE(task) << task.error().message();
  const Batch one = (*task)->random_batch(4, Random(1)), two = (*task)->random_batch(4, Random(1));
  EXPECT_EQ(one.condition, two.condition);
  EXPECT_EQ(one.windows, 4u);
  EXPECT_EQ(one.clean.size(), 4 * 4 * headset::kAnswerOutputs);
  EXPECT_NE(one.condition, (*task)->random_batch(4, Random(2)).condition);
}

TEST(ViewsTask, WhatCannotBeSeenIsUnknown) {
  const mien::test::Folder folder;
  std::vector<synthetic::FilmFrame> frames(1);
  frames[0].truth.visible = {1, 0};
  frames[0].truth.openness = {0, 1};
  frames[0].views.assign(4, std::vector<std::uint8_t>(kSide * kSide, 100));
  synthetic::HeadsetFilms films;
  for (auto* part : {&films.train, &films.validation}) {
    const auto path = folder / (part == &films.train ? "a.film" : "b.film");
    ASSERT_TRUE(synthetic::write_film(path, std::string(64, '0'), 4, kSide, frames));
    part->push_back(synthetic::HeadsetFilm::open(path).value());
  }
  const auto task = make_views_task(recipe_of(1), std::move(films), rig(), "");
  ASSERT_TRUE(task) << task.error().message();
  const Batch batch = (*task)->validation_batch(Random(1));
  ASSERT_EQ(batch.windows, 1u);
  EXPECT_TRUE(std::isnan(batch.clean[face::shape("jawOpen")]));
  EXPECT_TRUE(std::isnan(batch.clean[headset::kTongueOutput]));
  EXPECT_FALSE(std::isnan(batch.clean[face::shape("eyeBlink_L")]));
  EXPECT_TRUE(std::isnan(batch.clean[headset::kGazeOutput]));  // Of the eye that is shut.
  EXPECT_FALSE(std::isnan(batch.clean[headset::kGazeOutput + 2]));
}

TEST(Loss, WhatIsUnknownDiffersByNothingAndWhatDivergesIsSeen) {
  const float nan = std::nanf("");
  const torch::Tensor clean = torch::tensor({0.5F, nan, -0.5F});
  const torch::Tensor difference = difference_of(torch::tensor({1.0F, 9.0F, -0.5F}), clean);
  EXPECT_EQ(difference[0].item<float>(), 0.5F);
  EXPECT_EQ(difference[1].item<float>(), 0);
  EXPECT_EQ(difference[2].item<float>(), 0);
  EXPECT_TRUE(std::isnan(difference_of(torch::tensor({nan, 0.0F, 0.0F}), clean)[0].item<float>()));
}

TEST(ViewsTask, RefusesFilmsOfAnotherSize) {
  const mien::test::Folder folder;
  Recipe recipe = recipe_of(1);
  recipe.architecture.side = 48;
  recipe.architecture.condition = model::views_condition(48);
  EXPECT_FALSE(make_views_task(recipe, toy_films(folder.path()), rig(), ""));
  EXPECT_FALSE(make_views_task(
      *parse_recipe("[network]\narchitecture = \"causal\"\n[budget]\nsteps = 1", "r"), {}, rig(), ""));
}

TEST(ViewObstacle, StandsBeforeTheViewForAWhileOnly) {
  const std::vector<std::uint8_t> view(kSide * kSide, 100);
  std::size_t changed = 0, glares = 0, blinding = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed), again(seed);
    const ViewObstacle obstacle = draw_obstacle(100, random);
    const auto shown = [&](const ViewObstacle& of, std::size_t frame) {
      std::vector<std::uint8_t> seen = view;
      show_obstacle(of, frame, seen, kSide);
      return seen;
    };
    ASSERT_LT(obstacle.begin, obstacle.end);
    EXPECT_EQ(shown(obstacle, obstacle.end), view);
    if (obstacle.begin > 0) {
      EXPECT_EQ(shown(obstacle, obstacle.begin - 1), view);
    }
    const auto during = shown(obstacle, obstacle.begin);
    EXPECT_EQ(during, shown(draw_obstacle(100, again), obstacle.begin));
    std::vector<std::uint8_t> seen = view;
    const double hidden = show_obstacle(obstacle, obstacle.begin, seen, kSide);
    const bool saturates = std::ranges::any_of(seen, [](std::uint8_t pixel) { return pixel >= 250; });
    EXPECT_EQ(hidden > 0, !obstacle.is_glare || saturates);
    EXPECT_LE(hidden, 1);
    EXPECT_EQ(show_obstacle(obstacle, obstacle.end, seen, kSide), 0);
    if (during != view) ++changed;
    if (obstacle.is_glare) {
      ++glares;
      blinding += hidden > 0.5 ? 1 : 0;
      EXPECT_TRUE(std::ranges::all_of(during, [](std::uint8_t pixel) { return pixel >= 100; }));
    }
  }
  EXPECT_EQ(changed, 40u);
  EXPECT_GT(glares, 3u);
  EXPECT_GT(blinding, 0u);
  EXPECT_LT(blinding, glares);
  EXPECT_LT(glares, 25u);
}

TEST(ViewLook, GivesTheSameBitsAndAnotherView) {
  std::vector<std::uint8_t> view(kSide * kSide), memory;
  for (std::size_t i = 0; i < view.size(); ++i) view[i] = static_cast<std::uint8_t>(i * 7);
  std::vector<std::uint8_t> one = view, two = view;
  Random a(4), b(4);
  show_as(draw_look(a), one, kSide, memory);
  spoil_view(one, kSide, a);
  show_as(draw_look(b), two, kSide, memory);
  spoil_view(two, kSide, b);
  EXPECT_EQ(one, two);
  EXPECT_NE(one, view);
}

}  // namespace
}  // namespace mien::train::views_task_test
