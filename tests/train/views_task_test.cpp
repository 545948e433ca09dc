#include "mien/train/views_task.h"

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
#include "tests/folder.h"
#include "tests/project_path.h"

namespace mien::train::views_task_test {
namespace {

constexpr std::size_t kSide = 32;

Recipe recipe_of(std::size_t steps) {
  return *parse_recipe(fmt::format(R"(
seed = 3
[network]
architecture = "views"
side = {}
widths = [8, 16]
features = 16
d_model = 32
dropout = 0
[optimiser]
learning_rate = 3e-3
loss = "l2"
precision = "fp32"
batch = 16
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

/// Films in which a bright bar stands at a height that the jaw tells in the mouths' views, and that the left
/// lid tells in the left eye's.
study::HeadsetFilms toy_films(const std::filesystem::path& folder) {
  study::HeadsetFilms films;
  for (int f = 0; f < 4; ++f) {
    Random random = Random(11).fork("film", static_cast<std::uint64_t>(f));
    std::vector<study::FilmFrame> frames;
    for (int i = 0; i < 120; ++i) {
      study::FilmFrame& frame = frames.emplace_back();
      const auto jaw = static_cast<float>(random.uniform()), lid = static_cast<float>(random.uniform());
      frame.truth.weights[face::shape("jawOpen")] = jaw;
      frame.truth.weights[face::shape("eyeBlink_L")] = lid;
      frame.truth.openness = {1 - lid, 1};
      frame.truth.pupil_mm = {4, 4};
      for (std::size_t v = 0; v < 4; ++v) {
        const float height = v >= 2 ? jaw : v == 0 ? lid : 0.0F;
        std::vector<std::uint8_t>& view = frame.views.emplace_back();
        for (std::size_t y = 0; y < kSide; ++y)
          for (std::size_t x = 0; x < kSide; ++x) {
            const double off = std::abs(static_cast<double>(y) - 4 - 22 * double{height});
            view.push_back(
                static_cast<std::uint8_t>(40 + 160 * std::exp(-0.1 * off * off) + 20 * random.uniform()));
          }
      }
    }
    const auto path = folder / fmt::format("{}.film", f);
    EXPECT_TRUE(study::write_film(path, std::string(64, '0'), 4, kSide, frames));
    (f < 3 ? films.train : films.validation).push_back(study::HeadsetFilm::open(path).value());
  }
  return films;
}

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  return rig;
}

TEST(ViewsTask, LearnsAToyThatCanBeSeen) {
  const mien::test::Folder folder;
  const auto task = ViewsTask::create(recipe_of(250), toy_films(folder.path()), rig(), "rig text");
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
  for (const std::array<bool, 4> present :
       {std::array{true, true, true, true}, std::array{true, false, false, true},
        std::array{false, false, false, false}}) {
    std::vector<float> condition(architecture.condition);
    for (std::size_t i = 0; i < 4 * kSide * kSide; ++i) condition[i] = static_cast<float>(random.uniform());
    for (std::size_t v = 0; v < 4; ++v) condition[4 * kSide * kSide + v] = present[v] ? 1 : 0;
    const torch::Tensor wanted =
        predict_views(architecture, parameters, torch::tensor(condition).view({1, 1, -1}), {});
    std::vector<float> features(4 * architecture.features), answer(architecture.outputs);
    runs->find(std::span(condition).first(4 * kSide * kSide), present, memory, features);
    runs->answer(features, memory, answer);
    for (std::size_t i = 0; i < answer.size(); ++i)
      EXPECT_NEAR(answer[i], wanted.flatten()[static_cast<std::int64_t>(i)].item<float>(), 1e-4);
  }
}

TEST(ViewsTask, BatchesFollowTheirStream) {
  const mien::test::Folder folder;
  const auto task = ViewsTask::create(recipe_of(1), toy_films(folder.path()), rig(), "");
  ASSERT_TRUE(task) << task.error().message();
  const Batch one = (*task)->random_batch(4, Random(1)), two = (*task)->random_batch(4, Random(1));
  EXPECT_EQ(one.condition, two.condition);
  EXPECT_EQ(one.windows, 4u);
  EXPECT_EQ(one.clean.size(), 4 * headset::kAnswerOutputs);
  EXPECT_NE(one.condition, (*task)->random_batch(4, Random(2)).condition);
}

TEST(ViewsTask, WhatCannotBeSeenIsUnknown) {
  const mien::test::Folder folder;
  std::vector<study::FilmFrame> frames(1);
  frames[0].truth.visible = {1, 0};
  frames[0].truth.openness = {0, 1};
  frames[0].views.assign(4, std::vector<std::uint8_t>(kSide * kSide, 100));
  study::HeadsetFilms films;
  for (auto* part : {&films.train, &films.validation}) {
    const auto path = folder / (part == &films.train ? "a.film" : "b.film");
    ASSERT_TRUE(study::write_film(path, std::string(64, '0'), 4, kSide, frames));
    part->push_back(study::HeadsetFilm::open(path).value());
  }
  const auto task = ViewsTask::create(recipe_of(1), std::move(films), rig(), "");
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
  EXPECT_FALSE(ViewsTask::create(recipe, toy_films(folder.path()), rig(), ""));
  EXPECT_FALSE(ViewsTask::create(
      *parse_recipe("[network]\narchitecture = \"causal\"\n[budget]\nsteps = 1", "r"), {}, rig(), ""));
}

TEST(AugmentView, GivesTheSameBitsAndAnotherView) {
  std::vector<std::uint8_t> view(kSide * kSide), memory;
  for (std::size_t i = 0; i < view.size(); ++i) view[i] = static_cast<std::uint8_t>(i * 7);
  std::vector<std::uint8_t> one = view, two = view;
  Random a(4), b(4);
  augment_view(one, kSide, a, memory);
  augment_view(two, kSide, b, memory);
  EXPECT_EQ(one, two);
  EXPECT_NE(one, view);
}

}  // namespace
}  // namespace mien::train::views_task_test
