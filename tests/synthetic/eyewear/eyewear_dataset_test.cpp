#include "mien/synthetic/eyewear/eyewear_dataset.h"
#include "tests/project_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mien::synthetic::eyewear_dataset_test {
namespace {

TEST(EyewearDataset, IsTheSameOnAnyNumberOfThreads) {
  const sensor::Rig rig = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  const builtin_face::MarkerSet markers =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  EyewearDataRecipe recipe;
  recipe.wearers = 1;
  recipe.validation_wearers = 1;
  recipe.seconds = 12;
  const auto one = make_eyewear_dataset(recipe, rig, markers, no_progress, 1);
  const auto two = make_eyewear_dataset(recipe, rig, markers, no_progress, 2);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(two) << two.error().message();
  EXPECT_EQ(one->train.sensors.size(), 20u);
  EXPECT_EQ(one->train.markers.size(), 37u);
  ASSERT_EQ(one->train.sequences.size(), 1u);
  ASSERT_EQ(one->validation.sequences.size(), 1u);
  const LightSequence& sequence = one->train.sequences[0];
  EXPECT_EQ(sequence.frames, 72u * 60u);
  EXPECT_EQ(sequence.values.size(), sequence.frames * 20);
  EXPECT_EQ(sequence.displacement_m.size(), sequence.frames * 3 * 37);
  EXPECT_EQ(sequence.values, two->train.sequences[0].values);
  EXPECT_EQ(sequence.displacement_m, two->train.sequences[0].displacement_m);
  EXPECT_NE(one->validation.sequences[0].wearer, sequence.wearer);
  // Neutral at first, a wide open jaw in the range of motion.
  const auto largest_m = [&](std::size_t from, std::size_t to) {
    float most = 0;
    for (std::size_t i = from * 111; i < to * 111; ++i)
      most = std::max(most, std::abs(sequence.displacement_m[i]));
    return most;
  };
  EXPECT_GT(largest_m(600, 3600), 0.02F);
  EXPECT_LT(largest_m(0, 300), 0.015F) << "lids may blink";
}

TEST(EyewearDataset, ReadsItsTable) {
  const auto recipe =
      parse_eyewear_data_recipe("seed = 7\nwearers = 3\nvalidation_wearers = 2\nseconds = 30\n", "test");
  ASSERT_TRUE(recipe) << recipe.error().message();
  EXPECT_EQ(*recipe, (EyewearDataRecipe{7, 3, 2, 30}));
  for (const char* bad : {"wearers = 0", "seconds = nan", "seconds = 5", "performers = 3", "seed = -1",
                          "seed = 1e300", "wearers = 3.0", "x ="})
    EXPECT_FALSE(parse_eyewear_data_recipe(bad, "test")) << bad;
}

}  // namespace
}  // namespace mien::synthetic::eyewear_dataset_test
