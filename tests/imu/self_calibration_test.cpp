#include "mien/imu/self_calibration.h"

#include <gtest/gtest.h>

#include <iostream>
#include <optional>

#include "mien/core/units.h"
#include "tests/imu/clocked_pipeline.h"
#include "tests/imu/nodding_head.h"

namespace mien::imu::self_calibration_test {
namespace {

using testing_head::Faults;
using testing_head::play_unmarked;
using testing_head::record;
using testing_head::Recording;
using testing_head::rotation_of;
using testing_head::Script;
using testing_head::still_skin;

/// Talks all the time.
Quat busy_skin(std::size_t sensor, double t) {
  return exp_rotation(8 * kRadPerDeg * std::sin(9 * t + static_cast<double>(sensor)) * Vec3::UnitX());
}

PipelineSettings live_settings() {
  PipelineSettings settings;
  settings.calibrates_itself = true;
  return settings;
}

struct Seen {
  double calibrated_at = -1;  // True time.
  double rms_deg = 0;         // Of the still face's skin from then on.
  std::string hint;
  std::vector<tracker::PerformedStep> found;
  Calibration calibration;
};

Seen watch(const Recording& recording) {
  testing_head::ClockedPipeline pipeline(recording.rig, live_settings());
  Seen seen;
  double square = 0;
  std::size_t count = 0;
  play_unmarked(recording, pipeline,
                [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline& p) {
                  if (!p.hint().empty()) seen.hint = p.hint();
                  if (!p.calibration().complete) return;
                  if (seen.calibrated_at < 0) seen.calibrated_at = t;
                  for (const model::SensorFeature& sensor : frame.sensors) {
                    if (!sensor.has_rotation) continue;
                    const double angle = log_rotation(rotation_of(sensor)).norm();
                    square += angle * angle;
                    ++count;
                  }
                });
  if (count > 0) seen.rms_deg = std::sqrt(square / static_cast<double>(count)) / kRadPerDeg;
  seen.found = pipeline.found();
  seen.calibration = pipeline.calibration();
  return seen;
}

TEST(SelfCalibration, FindsStillnessNodAndShakeByItself) {
  const Script script;
  for (const std::uint64_t seed : {31U, 32U, 33U, 34U}) {
    const Seen seen = watch(record(script, Faults{}, 11, seed, still_skin));
    EXPECT_GE(seen.calibrated_at, script.nod_end - 0.6) << seed;
    EXPECT_LE(seen.calibrated_at, script.nod_end + 0.4) << seed;
    EXPECT_LT(seen.rms_deg, 1.5) << seed;
    std::cout << "seed " << seed << ": calibrated at " << seen.calibrated_at << " s, still face reads "
              << seen.rms_deg << " deg\n";
    ASSERT_EQ(seen.found.size(), 3u) << seed;
    for (const sensor::Score& score : seen.calibration.scores) EXPECT_TRUE(score.pass) << score.name;
    EXPECT_TRUE(std::ranges::any_of(seen.calibration.scores,
                                    [](const sensor::Score& score) { return score.name == "shake"; }));
  }
}

TEST(SelfCalibration, GivesWhatMarksWouldHaveGiven) {
  const Script script;
  const Recording recording = record(script, Faults{}, 5, 41, still_skin);
  testing_head::ClockedPipeline marked(recording.rig);
  testing_head::play(recording, script, marked,
                     [](double, const model::FeatureFrame&, const testing_head::ClockedPipeline&) {});
  const Calibration by_watching = watch(recording).calibration;
  ASSERT_TRUE(by_watching.complete);
  EXPECT_LT(by_watching.q_head_ear.angularDistance(marked.calibration().q_head_ear), 2 * kRadPerDeg);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(
        std::remainder(by_watching.sensors[i].heading_rad - marked.calibration().sensors[i].heading_rad,
                       2 * std::numbers::pi),
        0, 3 * kRadPerDeg);
}

TEST(SelfCalibration, AMovingHeadOrFaceCalibratesNothing) {
  Script restless;  // Nods and turns from the first moment on.
  restless.nod_begin = restless.nod_end = restless.shake_begin = restless.shake_end = 0;
  restless.move_begin = -2;
  restless.end = 20;
  EXPECT_LT(watch(record(restless, Faults{}, 5, 51, still_skin)).calibrated_at, 0);

  Script nods;
  nods.end = 10;
  EXPECT_LT(watch(record(nods, Faults{}, 5, 52, busy_skin)).calibrated_at, 0);
}

/// Talks from the nod on.
Quat talks_through_the_nod(std::size_t sensor, double t) {
  return t < 3.1 ? Quat::Identity() : busy_skin(sensor, t);
}

TEST(SelfCalibration, AFaceThatTalksThroughTheNodCalibratesNothing) {
  Script nods;
  nods.end = 9;
  nods.move_begin = 9;
  nods.shake_begin = nods.shake_end = 0;
  EXPECT_LT(watch(record(nods, Faults{}, 11, 55, talks_through_the_nod)).calibrated_at, 0);
}

TEST(SelfCalibration, AShakeIsNoNodAndSaysSo) {
  Script shakes;
  shakes.nod_begin = shakes.nod_end = 0;
  shakes.end = 12;
  shakes.move_begin = 12;
  const Seen seen = watch(record(shakes, Faults{}, 5, 53, still_skin));
  EXPECT_LT(seen.calibrated_at, 0);
  EXPECT_EQ(seen.hint, "that was no nod; nod straight down and up");
}

TEST(SelfCalibration, ASmallNodIsSaid) {
  Script small;
  small.shake_begin = small.shake_end = 0;
  small.nod_end = 4.7;  // The swing is 18 degrees times what little the ease lets through.
  small.nod_begin = 4.0;
  small.end = 9;
  small.move_begin = 9;
  const Recording recording = record(small, Faults{}, 5, 54, still_skin);
  const Seen seen = watch(recording);
  if (seen.calibrated_at < 0) {
    EXPECT_FALSE(seen.hint.empty());
  } else {
    EXPECT_LT(seen.rms_deg, 3);  // It was large enough after all.
  }
}

// A board that loses power for two seconds comes back with another clock and another heading.
TEST(SelfCalibration, ABoardThatBeganAnewIsBackAtOnce) {
  Script script;
  script.end = 40;
  for (const std::uint16_t board : {2, 5}) {
    Recording recording = record(script, Faults{}, 5, 61, still_skin);
    std::optional<DeviceTime> first;
    std::erase_if(recording.entries, [&](const testing_head::Entry& entry) {
      const double t = to_seconds(entry.arrival.time_since_epoch());
      return entry.samples[0].sensor == board && t > 20 && t < 22;
    });
    for (testing_head::Entry& entry : recording.entries) {
      if (entry.samples[0].sensor != board || to_seconds(entry.arrival.time_since_epoch()) < 22) continue;
      if (!first) first = entry.samples[0].time;
      for (sensor::Sample& sample : entry.samples)
        sample.time = DeviceTime(from_seconds(0.5)) + (sample.time - *first);
    }

    testing_head::ClockedPipeline pipeline(recording.rig, live_settings());
    sensor::TickRule ticks(recording.rig);
    model::FeatureFrame frame;
    double back_at = -1;
    double worst_deg = 0;
    const auto fire = [&](HostTime now) {
      while (const auto tick = ticks.due(now)) {
        pipeline.tick(tick->frame, frame);
        const double t = to_seconds(tick->fired.time_since_epoch());
        if (t < 22) continue;
        const bool all = std::ranges::all_of(frame.sensors, &model::SensorFeature::has_rotation);
        if (all && back_at < 0) back_at = t;
        if (back_at < 0) continue;
        EXPECT_TRUE(all) << t;
        for (const model::SensorFeature& sensor : frame.sensors)
          worst_deg = std::max(worst_deg, log_rotation(rotation_of(sensor)).norm() / kRadPerDeg);
      }
    };
    for (const testing_head::Entry& entry : recording.entries) {
      fire(entry.arrival);
      for (const sensor::Sample& sample : entry.samples) {
        ticks.add(entry.arrival, sample);
        pipeline.add(entry.arrival, sample);
      }
      fire(entry.arrival);
    }
    std::cout << (board == 5 ? "ear" : "face") << " sensor back at " << back_at << " s, then at most "
              << worst_deg << " deg off a still face\n";
    EXPECT_GT(back_at, 22);
    EXPECT_LT(back_at, 22.5);
    EXPECT_LT(worst_deg, 8);
  }
}

}  // namespace
}  // namespace mien::imu::self_calibration_test
