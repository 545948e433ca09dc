#include "mien/train/tasks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/train/trainer.h"
#include "tests/folder.h"
#include "tests/train/toy_data.h"

namespace mien::train::marker_task_test {
namespace {

/// Two sensors and one marker that goes where they say.
synthetic::LightDataset toy_light(std::uint32_t first, std::size_t wearers, std::size_t frames = 200) {
  synthetic::LightDataset data{.sensors = {"s0", "s1"}, .markers = {"chin"}, .sequences = {}};
  for (std::size_t w = 0; w < wearers; ++w) {
    synthetic::LightSequence& s = data.sequences.emplace_back();
    s.wearer = first + static_cast<std::uint32_t>(w);
    s.frames = frames;
    for (std::size_t f = 0; f < frames; ++f) {
      const double t = static_cast<double>(s.wearer) + 0.05 * static_cast<double>(f);
      const double a = std::sin(t), b = std::sin(1.7 * t);
      for (const double v : {a, b}) s.values.push_back(static_cast<float>(v));
      s.present.insert(s.present.end(), {1, 1});
      for (const double m : {0.02 * a, -0.01 * b, 0.03 * a * b})
        s.displacement_m.push_back(static_cast<float>(m));
    }
  }
  return data;
}

std::string toy_marker_recipe(std::size_t steps) {
  std::string recipe = toy_causal_recipe(steps, "[augmentation]\nsensor_loss = 0.02\nmany_lost = 0\n");
  recipe.replace(recipe.find("\"l2\""), 4, "\"points\"");
  return recipe;
}

TEST(MarkerTask, LearnsAToyBetterThanRidge) {
  const mien::test::Folder folder;
  const auto task = make_marker_task(*parse_recipe(toy_marker_recipe(400), "test"), toy_light(0, 6),
                                     toy_light(20, 2), "# rig");
  ASSERT_TRUE(task) << task.error().message();
  const auto report =
      train(**task, {.out = folder / "toy.safetensors", .device = "cpu", .threads = 1}, no_progress);
  ASSERT_TRUE(report) << report.error().message();
  const auto results = nlohmann::json::parse(report->results)["markers"];
  EXPECT_LT(results["mean_mm"].get<double>(), 0.8 * results["ridge_mean_mm"].get<double>());
  EXPECT_LT(results["ridge_mean_mm"].get<double>(), results["neutral_mean_mm"].get<double>());
  const auto file = eyewear::read_marker_network(folder / "toy.safetensors");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->markers, std::vector<std::string>{"chin"});
  EXPECT_EQ(file->rig, "# rig");
  EXPECT_EQ(nlohmann::json::parse(file->results)["markers"], results);
}

TEST(MarkerTask, RefusesWhatCannotBeTrained) {
  const Recipe recipe = *parse_recipe(toy_marker_recipe(10), "test");
  EXPECT_FALSE(make_marker_task(recipe, {}, toy_light(0, 1), ""));
  EXPECT_FALSE(make_marker_task(recipe, toy_light(0, 1, 20), toy_light(1, 1), "")) << "shorter than a window";
  EXPECT_FALSE(make_marker_task(*parse_recipe(toy_recipe(10), "test"), toy_light(0, 1), toy_light(1, 1), ""))
      << "a network that waits for a window";
  EXPECT_FALSE(make_marker_task(recipe, toy_light(0, 2), toy_light(1, 1), "")) << "the same people";
  synthetic::LightDataset sick = toy_light(0, 1);
  sick.sequences[0].values[3] = std::nanf("");
  EXPECT_FALSE(make_marker_task(recipe, sick, toy_light(1, 1), ""));
  synthetic::LightDataset cut = toy_light(0, 1);
  cut.sequences[0].present.pop_back();
  EXPECT_FALSE(make_marker_task(recipe, cut, toy_light(1, 1), ""));
}

}  // namespace
}  // namespace mien::train::marker_task_test
