#include "lab/eyewear/watched_wearer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mien/builtin_face/builtin_face.h"
#include "mien/eyewear/light_grid.h"
#include "mien/synthetic/confidence.h"
#include "mien/synthetic/eyewear/worn_glasses.h"
#include "tests/lab/eyewear/untrained.h"

namespace mien::lab::watched_wearer_test {
namespace {

using test::untrained;

const eyewear::MarkedFace& marked() {
  static const eyewear::MarkedFace face =
      eyewear::MarkedFace::create("all", eyewear::mark_builtin(test::all_markers()).value()).value();
  return face;
}

std::vector<std::string> sensors() {
  return eyewear::photo_sensor_names(test::eyewear_rig());
}

TEST(WatchedByGlasses, TheTableFitsTheModelAndWhoLearntNothingMeasuresNothing) {
  const auto people = watch_wearers(2, 11, 5, test::eyewear_rig(), no_progress, 2);
  ASSERT_TRUE(people) << people.error().message();
  for (const LightPerson& person : *people) {
    ASSERT_EQ(person.light.size(), person.truth.size());
    EXPECT_GT(person.light.size(), 600U);
    const auto there = [](const eyewear::LightFrame& light) {
      return std::ranges::count(light.present, std::uint8_t{1}) == std::ssize(light.present);
    };
    EXPECT_TRUE(std::ranges::all_of(person.light, there));
  }
  eyewear::MarkerNetworkFile model = untrained();
  const auto group = watched_by(model, marked(), sensors(), "people", *people);
  ASSERT_TRUE(group) << group.error().message();
  const auto table = synthetic::measure_confidence(*group, 5, no_progress, 2);
  ASSERT_TRUE(table) << table.error().message();
  model.confidence = *table;
  EXPECT_TRUE(eyewear::format_marker_network(model));
  const auto rows = synthetic::study_confidence(*table, {*group}, 6, no_progress, 2);
  ASSERT_TRUE(rows) << rows.error().message();
  EXPECT_EQ(rows->front().measured, 0);
}

TEST(WatchedByGlasses, WhatIsLostIsNotCoveredAndChangesTheAnswer) {
  face::Motion motion = synthetic::range_of_motion(Random(3));
  motion.frames.resize(120);
  const auto person = watch_wearer(motion, builtin_face::make_builtin(), test::eyewear_rig(), Random(2));
  ASSERT_TRUE(person) << person.error().message();
  const auto group = watched_by(untrained(), marked(), sensors(), "someone", {*person});
  ASSERT_TRUE(group) << group.error().message();
  const synthetic::WatchedPerson& watched = *group->people.front();
  const synthetic::Watched all = watched.watch(0, Random(1)).value(),
                           some = watched.watch(5, Random(1)).value();
  const auto count = static_cast<float>(watched.sensor_count());
  EXPECT_EQ(all.coverage.back()[7], 1);
  EXPECT_FLOAT_EQ(some.coverage.back()[7], (count - 5) / count);
  EXPECT_NE(all.answer.back(), some.answer.back());
  EXPECT_EQ(watched.watch(100, Random(1)).value().coverage.front()[7], 0);
  EXPECT_FALSE(watched_by(untrained(), marked(), {"elsewhere"}, "someone", {*person}));
}

TEST(FaultyWearers, EveryFaultBefallsTheSamePerformance) {
  const auto group =
      faulty_wearers(test::untrained(), marked(), test::eyewear_rig(), "people", 1, 4, false, 7);
  ASSERT_TRUE(group) << group.error().message();
  EXPECT_EQ(std::set<std::string>(group->faults.begin(), group->faults.end()).size(), group->faults.size());
  EXPECT_EQ(group->faults.front(), "clean");
  std::vector<synthetic::Watched> seen;
  const auto done = group->people.front()->watch_each(
      [&](std::size_t, const synthetic::Watched& watched) { seen.push_back(watched); });
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(seen.size(), group->faults.size());
  for (std::size_t f = 0; f < seen.size(); ++f) {
    EXPECT_EQ(seen[f].truth, seen[0].truth) << group->faults[f];
    EXPECT_EQ(seen[f].answer.size(), seen[f].truth.size());
    if (f > 0) {
      EXPECT_FALSE(seen[f].answer == seen[0].answer) << "nothing befell: " << group->faults[f];
    }
  }
  const auto silent = std::ranges::find(group->faults, "silent for 2 s") - group->faults.begin();
  const auto& coverage = seen[static_cast<std::size_t>(silent)].coverage;
  EXPECT_NEAR(static_cast<double>(std::ranges::count(coverage, tracker::Coverage{})), 114, 10)
      << "two seconds, less the tenth in which the last light stands";
}

}  // namespace
}  // namespace mien::lab::watched_wearer_test
