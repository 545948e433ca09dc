#include "mien/study/imu/short_recipe.h"

#include <gtest/gtest.h>

#include <set>

#include "mien/core/toml.h"

namespace mien::study::short_recipe_test {
namespace {

TEST(ShortRecipes, HaveTheDataThatTheyAreToldToHave) {
  DataRecipe data = short_data(7);
  data.performers = 31;
  const auto read = parse_data_recipe(data_table(data), "recipe");
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

}  // namespace
}  // namespace mien::study::short_recipe_test
