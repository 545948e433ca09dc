#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mien/core/units.h"
#include "mien/imu/pipeline.h"
#include "tests/imu/clocked_pipeline.h"
#include "tests/imu/nodding_head.h"

namespace mien::imu::pipeline_rest_test {
namespace {

using testing_head::ClockedPipeline;
using testing_head::Faults;
using testing_head::play;
using testing_head::record;
using testing_head::Recording;
using testing_head::rotation_of;
using testing_head::Script;
using testing_head::still_skin;

constexpr std::size_t kFaces = 5, kPushed = 2;

/// A sensor that is taken off and put on again: from t = 14 s it sits elsewhere by this.
struct Pushed {
  Vec3 by_rad;
  Quat operator()(std::size_t sensor, double t) const {
    if (sensor != kPushed) return Quat::Identity();
    return exp_rotation(testing_head::ease((t - 14) / 0.5) * by_rad);
  }
};

Script script_until(double end) {
  Script script;
  script.move_begin = 100;  // The head sways.
  script.end = end;
  return script;
}

struct Played {
  std::vector<std::array<double, kFaces>> error_rad;  // By frame, against the neutral skin.
  std::vector<double> t;
  std::vector<std::array<bool, kFaces>> present;
  std::vector<Vec3> bits;  // All rotations, as they came.
  std::vector<tracker::RestOutcome> outcomes;
  std::array<SensorStatus, kFaces> status;

  [[nodiscard]] double worst_deg(std::size_t sensor, double from_s, double to_s) const {
    double worst = 0;
    for (std::size_t f = 0; f < t.size(); ++f)
      if (t[f] >= from_s && t[f] < to_s) worst = std::max(worst, kDegPerRad * error_rad[f][sensor]);
    return worst;
  }
};

/// Rests from `rest_s` on for two seconds; `move`: how the skin really turns meanwhile.
template <class Skin>
Played rest_at(double rest_s, const Script& script, const Skin& skin, const PipelineSettings& settings = {},
               std::uint64_t seed = 5) {
  const Recording recording = record(script, Faults{}, kFaces, seed, skin);
  ClockedPipeline pipeline(recording.rig, settings);
  Played run;
  bool asked = false;
  play(recording, script, pipeline, [&](double t, const model::FeatureFrame& frame, ClockedPipeline& of) {
    auto& errors = run.error_rad.emplace_back();
    auto& present = run.present.emplace_back();
    run.t.push_back(t);
    for (std::size_t i = 0; i < kFaces; ++i) {
      present[i] = frame.sensors[i].has_rotation;
      if (!present[i]) continue;
      run.bits.push_back(log_rotation(rotation_of(frame.sensors[i])));
      errors[i] = run.bits.back().norm();
    }
    if (of.rested()) run.outcomes.push_back(*of.rested());
    if (asked || t < rest_s) return;
    asked = true;
    of.rest(frame.time + std::chrono::milliseconds(1), frame.time + std::chrono::milliseconds(2001));
  });
  for (std::size_t i = 0; i < kFaces; ++i) run.status[i] = pipeline.status(static_cast<std::uint16_t>(i));
  return run;
}

TEST(PipelineRest, CorrectsASensorThatWasPutOnAgain) {
  for (const Vec3& by_deg : {Vec3(25, 0, 0), Vec3(-8, 6, 0), Vec3(10, -25, 20)}) {
    const Played run = rest_at(20, script_until(30), Pushed{kRadPerDeg * by_deg});
    EXPECT_GT(run.worst_deg(kPushed, 16, 20), 0.6 * by_deg.norm());
    ASSERT_EQ(run.outcomes.size(), 1u);
    EXPECT_EQ(run.outcomes[0].corrected, (std::vector<std::uint16_t>{0, 1, 2, 3, 4}));
    for (std::size_t i = 0; i < kFaces; ++i)
      EXPECT_LT(run.worst_deg(i, 22.2, 30), 1.5) << i << " " << by_deg.transpose();
    EXPECT_LT(std::sqrt(run.status[kPushed].drift_rad2.trace()), 3 * kRadPerDeg);
  }
}

TEST(PipelineRest, WithoutARestItStaysWhereItWasPut) {
  const Played run = rest_at(1000, script_until(30), Pushed{kRadPerDeg * Vec3(25, 0, 0)});
  EXPECT_TRUE(run.outcomes.empty());
  EXPECT_GT(run.worst_deg(kPushed, 29, 30), 15);
}

TEST(PipelineRest, ASensorThatMovesIsNotCorrected) {
  const auto speaking = [](std::size_t sensor, double t) -> Quat {
    if (sensor != 1) return Quat::Identity();
    return exp_rotation(Vec3(testing_head::ease(t - 12) * 4 * kRadPerDeg * (1 + std::sin(9 * t)), 0, 0));
  };
  const Played run = rest_at(20, script_until(24), speaking);
  ASSERT_EQ(run.outcomes.size(), 1u);
  EXPECT_EQ(run.outcomes[0].moved, std::vector<std::uint16_t>{1});
  EXPECT_EQ(run.outcomes[0].corrected.size(), kFaces - 1);
  EXPECT_TRUE(run.outcomes[0].absent.empty());
  EXPECT_GT(run.worst_deg(1, 22.5, 24), 6) << "its mean was not taken for neutral";
}

TEST(PipelineRest, ASensorThatIsLeftOutIsMeasuredToo) {
  // So strict a limit leaves them all out soon after the calibration.
  PipelineSettings settings;
  settings.unsure_rad = 2 * kRadPerDeg;
  settings.drift.heading_walk = 3e-2;
  settings.drift.correlation_s = settings.drift.first_correlation_s = 1e6;
  const Played run = rest_at(20, script_until(24), Pushed{kRadPerDeg * Vec3(0, 20, 0)}, settings);
  std::size_t before = 0, after = 0;
  for (std::size_t f = 0; f < run.t.size(); ++f) {
    if (run.t[f] > 19 && run.t[f] < 22) before += run.present[f][0] ? 1 : 0;
    if (run.t[f] > 22.1 && run.t[f] < 22.5) after += run.present[f][0] ? 1 : 0;
  }
  EXPECT_EQ(before, 0u);
  EXPECT_GT(after, 20u) << "and given again";
  ASSERT_EQ(run.outcomes.size(), 1u);
  EXPECT_EQ(run.outcomes[0].corrected.size(), kFaces);
}

TEST(PipelineRest, ASensorThatIsMissingIsAbsent) {
  const Script script = script_until(24);
  Recording recording = record(script, Faults{}, kFaces, 5, still_skin);
  std::erase_if(recording.entries, [](const testing_head::Entry& entry) {
    const double arrival_s = to_seconds(entry.arrival.time_since_epoch());
    return entry.samples[0].sensor == 3 && arrival_s > 20.4 && arrival_s < 30;
  });
  ClockedPipeline pipeline(recording.rig);
  std::vector<tracker::RestOutcome> outcomes;
  bool asked = false;
  play(recording, script, pipeline, [&](double t, const model::FeatureFrame& frame, ClockedPipeline& of) {
    if (of.rested()) outcomes.push_back(*of.rested());
    if (asked || t < 20) return;
    asked = true;
    of.rest(frame.time + std::chrono::milliseconds(1), frame.time + std::chrono::seconds(2));
  });
  ASSERT_EQ(outcomes.size(), 1u);
  EXPECT_EQ(outcomes[0].absent, std::vector<std::uint16_t>{3});
  EXPECT_EQ(outcomes[0].corrected, (std::vector<std::uint16_t>{0, 1, 2, 4}));
}

TEST(PipelineRest, ANodMeanwhileDoesNoHarm) {
  // The head nods and turns all through the rest, by 20 and 40 degrees.
  Script script;
  script.end = 30;
  const Played run = rest_at(20, script, Pushed{kRadPerDeg * Vec3(20, 5, 5)});
  ASSERT_EQ(run.outcomes.size(), 1u);
  for (std::size_t i = 0; i < kFaces; ++i) EXPECT_LT(run.worst_deg(i, 22.2, 30), 4) << i;
}

TEST(PipelineRest, IsNoRestWithoutACalibrationOrWhereNothingIsFollowed) {
  EXPECT_TRUE(rest_at(1, script_until(9.5), still_skin).outcomes.empty()) << "a calibration came meanwhile";
  PipelineSettings frozen;
  frozen.track_heading = false;
  EXPECT_TRUE(rest_at(12, script_until(16), still_skin, frozen).outcomes.empty());
}

TEST(PipelineRest, TheSameCallsGiveTheSameBits) {
  const auto run = [] { return rest_at(16, script_until(20), Pushed{kRadPerDeg * Vec3(9, 3, 0)}); };
  EXPECT_EQ(run().bits, run().bits);
}

}  // namespace
}  // namespace mien::imu::pipeline_rest_test
