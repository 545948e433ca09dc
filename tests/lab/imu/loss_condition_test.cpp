#include "lab/imu/loss_condition.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/virtual/three_sensors.h"

namespace mien::lab::loss_condition_test {
namespace {

sensor::Rig rig() {
  return virt::test::three_sensors();
}

TEST(LossConditions, FitTheRigAndHaveNamesOfTheirOwn) {
  const std::vector<LossCondition> conditions = loss_conditions(rig());
  std::set<std::string> names, silent;
  for (const LossCondition& condition : conditions) {
    EXPECT_FALSE(condition.name().empty());
    names.insert(condition.name());
    EXPECT_NE(condition.fault, Fault::none);
    EXPECT_NE(condition.fault, Fault::sensors_silent) << "the rig has no more than two on the face";
    if (condition.fault == Fault::sensor_silent) silent.insert(condition.sensor);
  }
  EXPECT_EQ(names.size(), conditions.size());
  EXPECT_EQ(silent, (std::set<std::string>{"mentalis", "buccinator_L"}));
}

TEST(LossConditions, DrawWhatTheyDoNotName) {
  const auto one = impairment({Fault::sensors_silent, 1, {}}, rig(), 10, 20, Random(1));
  const auto both = impairment({Fault::sensors_silent, 2, {}}, rig(), 10, 20, Random(1));
  ASSERT_TRUE(one && both);
  ASSERT_EQ(one->troubles.silences.size(), 1U);
  ASSERT_EQ(both->troubles.silences.size(), 2U);
  EXPECT_EQ(both->troubles.silences[0].sensor, one->troubles.silences[0].sensor);
  EXPECT_NE(both->troubles.silences[1].sensor, one->troubles.silences[0].sensor);
  const auto restart = impairment({Fault::restart, 0, {}}, rig(), 10, 20, Random(1));
  ASSERT_TRUE(restart);
  EXPECT_EQ(restart->troubles.restarts.at(0).at_s, 15);
  const auto bursts = impairment({Fault::bursts, 10, {}}, rig(), 10, 20, Random(1));
  ASSERT_TRUE(bursts);
  EXPECT_DOUBLE_EQ(bursts->network.burst_share, 0.1);
}

TEST(LossConditions, FreezeSilenceAndSpoil) {
  const auto frozen = impairment({Fault::frozen, 1, {}}, rig(), 10, 20, Random(1));
  ASSERT_TRUE(frozen);
  ASSERT_EQ(frozen->troubles.frozen.size(), 1U);
  EXPECT_EQ(frozen->troubles.frozen[0].from_s, 10);
  EXPECT_EQ(frozen->troubles.frozen[0].to_s, 20);
  const auto silent = impairment({Fault::all_silent, 2, {}}, rig(), 10, 20, Random(1));
  ASSERT_TRUE(silent);
  EXPECT_EQ(silent->troubles.silences.at(0).sensor, std::nullopt);
  EXPECT_EQ(silent->troubles.silences[0].to_s, 17);
  EXPECT_DOUBLE_EQ(impairment({Fault::corrupted, 5, {}}, rig(), 10, 20, Random(1))->network.corrupted, 0.05);
  EXPECT_DOUBLE_EQ(impairment({Fault::truncated, 5, {}}, rig(), 10, 20, Random(1))->network.truncated, 0.05);
}

TEST(LossConditions, SayWhatTheRigLacks) {
  for (const LossCondition& condition :
       {LossCondition{Fault::sensor_silent, 0, "nose"}, LossCondition{Fault::sensors_silent, 3, {}},
        LossCondition{Fault::frozen, 3, {}}}) {
    const auto wrong = impairment(condition, rig(), 0, 1, Random(1));
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, ErrorCode::not_found);
  }
}

}  // namespace
}  // namespace mien::lab::loss_condition_test
