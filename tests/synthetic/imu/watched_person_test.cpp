#include "mien/synthetic/imu/watched_person.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/synthetic/confidence.h"
#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::synthetic::watched_person_test {
namespace {

ImuPerson someone() {
  ImuPerson out;
  out.features = tracker::test::turning(700);
  out.truth.resize(700);
  for (std::size_t f = 0; f < out.truth.size(); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      out.truth[f][k] = static_cast<float>(0.5 + 0.4 * std::sin(0.1 * static_cast<double>(f + k)));
  return out;
}

TEST(WatchedByImus, TheTableFitsTheModelWhicheverNetworkItHas) {
  const std::vector<std::string> sensors = {"mentalis", "buccinator_L"};
  for (model::ModelFile model :
       {tracker::test::tiny_causal_model(sensors), tracker::test::tiny_model(sensors)}) {
    const WatchedGroup group = watched_by(model, sensors, "people", {someone(), someone(), someone()});
    const auto table = measure_confidence(group, 5, no_progress, 1);
    ASSERT_TRUE(table) << table.error().message();
    model.confidence = *table;
    EXPECT_TRUE(model::format_model(model));
  }
}

TEST(WatchedByImus, WhatIsLostIsNotCovered) {
  const std::vector<std::string> sensors = {"mentalis", "buccinator_L"};
  const WatchedGroup group =
      watched_by(tracker::test::tiny_causal_model(sensors), sensors, "someone", {someone()});
  const auto coverage = [&](std::size_t lost, std::uint64_t seed) {
    return group.people.front()->watch(lost, Random(seed)).value().coverage.back()[7];
  };
  EXPECT_EQ(coverage(0, 1), 1);
  EXPECT_EQ(coverage(2, 1), 0);
  // The tiny model's ridge reads all from the first sensor.
  std::size_t covered = 0, uncovered = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) ++(coverage(1, seed) == 1 ? covered : uncovered);
  EXPECT_GT(covered, 0U);
  EXPECT_GT(uncovered, 0U);
}

TEST(WithoutSensors, SoManyAreSilentThroughout) {
  const auto features = tracker::test::turning(5, 4);
  for (const std::size_t lost : {0U, 1U, 3U, 9U})
    for (const model::FeatureFrame& frame : without_sensors(features, lost, Random(1)))
      EXPECT_EQ(std::ranges::count_if(frame.sensors, &model::SensorFeature::has_rotation),
                static_cast<std::ptrdiff_t>(4 - std::min<std::size_t>(lost, 4)));
}

}  // namespace
}  // namespace mien::synthetic::watched_person_test
