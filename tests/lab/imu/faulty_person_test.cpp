#include "lab/imu/faulty_person.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::faulty_person_test {
namespace {

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

sensor::Rig rig() {
  sensor::Rig out = virt::test::three_sensors();
  out.faults_toml =
      "mount_rotation_deg = 180\nmount_position_mm = 3\nslip_deg_per_sqrt_min = 0.5\n"
      "adhesive_lag_ms = [5, 20]\ngyro_bias_dps = 1\ngyro_scale = 0.005\n"
      "accel_bias_mg = 5\nclock_offset_s = [1, 50]\nradio_delay_min_ms = 1\n";
  return out;
}

TEST(FaultyPeople, EveryFaultBefallsTheSamePerformance) {
  const auto group =
      faulty_people(tracker::test::tiny_causal_model(kSensors), rig(), "people", 2, 3, true, 7);
  ASSERT_TRUE(group) << group.error().message();
  EXPECT_EQ(std::set<std::string>(group->faults.begin(), group->faults.end()).size(), group->faults.size());
  EXPECT_EQ(group->faults.front(), "clean");
  ASSERT_EQ(group->people.size(), 2U);
  for (const auto& person : group->people) {
    std::vector<synthetic::Watched> seen;
    const auto done = person->watch_each([&](std::size_t fault, const synthetic::Watched& watched) {
      EXPECT_EQ(fault, seen.size());
      seen.push_back(watched);
    });
    ASSERT_TRUE(done) << done.error().message();
    ASSERT_EQ(seen.size(), group->faults.size());
    const auto longest = [](const synthetic::Watched& w) {
      float most = 0;
      for (const face::BlendshapeWeights& weights : w.truth)
        most = std::max(most, *std::ranges::max_element(weights.values));
      return most;
    };
    for (std::size_t f = 0; f < seen.size(); ++f) {
      EXPECT_EQ(seen[f].answer.size(), seen[f].truth.size());
      EXPECT_EQ(seen[f].coverage.size(), seen[f].truth.size());
      if (group->faults[f] == "all silent for 2 s") {  // Without packets there are no frames.
        EXPECT_NEAR(static_cast<double>(seen[f].truth.size()), 60, 40);
        continue;
      }
      EXPECT_NEAR(static_cast<double>(seen[f].truth.size()), 180, 20) << group->faults[f];
      EXPECT_NEAR(longest(seen[f]), longest(seen[0]), 0.02) << "another performance: " << group->faults[f];
      // What is late by the same for all is taken off by the clocks, and in three seconds no sensor leaves.
      if (f > 0 && group->faults[f] != "lag 100 ms" && group->faults[f] != "sensors silent now and then") {
        EXPECT_FALSE(seen[f].answer == seen[0].answer) << "nothing befell: " << group->faults[f];
      }
    }
  }
}

TEST(FaultyPeople, AreRefusedWithoutAModelOrFaultsThatFit) {
  sensor::Rig wrong = rig();
  wrong.faults_toml = "packet_loss = 2\n";
  EXPECT_FALSE(faulty_people(tracker::test::tiny_causal_model(kSensors), wrong, "people", 1, 1, false, 1));
  const auto group =
      faulty_people(tracker::test::tiny_causal_model({"nose"}), rig(), "people", 1, 1, false, 1);
  ASSERT_TRUE(group);
  const auto done = group->people.front()->watch_each([](std::size_t, const synthetic::Watched&) {});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::lab::faulty_person_test
