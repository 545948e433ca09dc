#include "lab/imu/placement/placement_training.h"

#include <gtest/gtest.h>

#include "lab/imu/part_rig.h"
#include "tests/lab/imu/untrained.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::placement_training_test {
namespace {

PlacementTrainingRequest small_request() {
  PlacementTrainingRequest request;
  request.seeds = 2;
  request.steps = 6;
  request.data.performers = 3;
  request.data.validation_performers = 1;
  request.data.seconds = request.data.device_seconds = 2;
  request.test_people = 2;
  request.test_seconds = 2;
  return request;
}

TEST(TrainPlacements, GivesEachSetItsOwnDataOfTheSamePeople) {
  const sensor::Rig both = virt::test::three_sensors();
  const sensor::Rig one = *rig_with_sensors(both, std::vector<std::string>{"mentalis"});
  test::Untrained untrained;
  const std::vector<PlacementRig> rigs = {{"two", "two sensors", both}, {"one", "one sensor", one}};
  const auto trained = train_placements(small_request(), rigs, untrained.trainer(), no_progress);
  ASSERT_TRUE(trained) << trained.error().message();
  ASSERT_EQ(untrained.asked.size(), 4U);
  EXPECT_EQ(untrained.asked[0].data_key, untrained.asked[1].data_key);
  EXPECT_NE(untrained.asked[0].recipe, untrained.asked[1].recipe);
  EXPECT_TRUE(untrained.asked[0].recipe.starts_with("seed = 100\n"));
  EXPECT_TRUE(untrained.asked[1].recipe.starts_with("seed = 101\n"));
  EXPECT_NE(untrained.asked[0].data_key, untrained.asked[2].data_key);
  // The same budget and the same performances, whatever is worn.
  EXPECT_EQ(untrained.asked[0].recipe, untrained.asked[2].recipe);
  const dataset::Dataset &with_two = untrained.data.at("two-1").train,
                         &with_one = untrained.data.at("one-1").train;
  EXPECT_EQ(with_two.sensors.size(), 2U);
  EXPECT_EQ(with_one.sensors, (std::vector<std::string>{"mentalis"}));
  EXPECT_EQ(with_two.sequences.front().weights, with_one.sequences.front().weights);

  ASSERT_EQ(trained->size(), 2U);
  for (const TrainedPlacement& row : *trained)
    for (const SeedFigures* figures : {&row.device.pve_mm, &row.device.mse, &row.lab.pve_mm, &row.lab.mse}) {
      ASSERT_EQ(figures->size(), 2U);
      for (const std::vector<double>& seed : *figures) EXPECT_EQ(seed.size(), 2U);
    }
  EXPECT_NE((*trained)[0].device.pve_mm[0], (*trained)[0].device.pve_mm[1]);
}

}  // namespace
}  // namespace mien::lab::placement_training_test
