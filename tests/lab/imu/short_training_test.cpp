#include "lab/imu/short_training.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <set>

#include "mien/core/toml.h"

namespace mien::lab::short_training_test {
namespace {

TEST(ShortRecipes, HaveTheDataThatTheyAreToldToHave) {
  synthetic::DataRecipe data = short_data(7);
  data.performers = 31;
  const auto read = synthetic::parse_data_recipe(data_table(data), "recipe");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->performers, 31);
  EXPECT_EQ(read->seed, 7U);
  EXPECT_EQ(read->device_share, data.device_share);
  EXPECT_NEAR(read->kinematics.direction_rad, data.kinematics.direction_rad, 1e-6);
}

TEST(ShortRecipes, AreTomlAndNoTwoAlike) {
  std::set<std::string> texts;
  for (const ShortNetwork network :
       {ShortNetwork::recurrent, ShortNetwork::transformer, ShortNetwork::diffusion})
    for (const std::size_t window : {30, 120})
      for (const std::uint64_t seed : {1, 2}) {
        const std::string text =
            short_recipe({.seed = seed, .steps = 60, .network = network, .window = window}, short_data(1));
        const auto table = parse_toml(text, "recipe");
        ASSERT_TRUE(table) << table.error().message();
        EXPECT_EQ((*table)["budget"]["steps"].value<std::int64_t>(), 60);
        const auto batch = (*table)["optimiser"]["batch"].value<std::int64_t>();
        EXPECT_EQ(batch.value_or(0) * static_cast<std::int64_t>(window), 3840);
        EXPECT_TRUE(texts.insert(text).second);
      }
}

TEST(TrainingSeed, IsWhatARecipeTakes) {
  EXPECT_EQ(training_seed(1, 0), 100U);
  EXPECT_EQ(training_seed(7, 2), 702U);
  constexpr std::uint64_t kHuge = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(recipe_seed(kHuge >> 1U), kHuge >> 1U);
  synthetic::DataRecipe data = short_data(recipe_seed(kHuge));
  EXPECT_TRUE(synthetic::parse_data_recipe(data_table(data), "recipe"));
  for (const std::uint64_t seed : {kHuge, kHuge - 1, kHuge >> 1U, kHuge / 100}) {
    const auto table = parse_toml(short_recipe({.seed = training_seed(seed, 99)}, data), "recipe");
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_GE((*table)["seed"].value<std::int64_t>().value_or(-1), 0) << seed;
  }
}

}  // namespace
}  // namespace mien::lab::short_training_test
