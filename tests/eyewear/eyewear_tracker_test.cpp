#include "mien/eyewear/eyewear_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mien/builtin_face/builtin_face.h"
#include "tests/eyewear/glasses.h"

namespace mien::eyewear::eyewear_tracker_test {
namespace {

using face::Provenance;
using face::shape;
using test::Glasses;

const std::size_t kJaw = shape("jawOpen");
constexpr std::size_t kSensors = 4;
constexpr double kNeutral = -1.8;
/// Log light that a wide open jaw takes away from the first sensor.
constexpr double kJawLight = -1.2;

/// The first sensor's light tells how far the jaw is open, when it changes by a usual range; the others see
/// nothing that moves.
Eigen::MatrixXd gain_m() {
  static const Eigen::MatrixXd gain = [] {
    const builtin_face::PlacedMarkers placed =
        builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), test::mouth_markers()).value();
    face::BlendshapeWeights open;
    open[kJaw] = 1;
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(placed.at({}).size(), kSensors);
    columns.col(0) = (placed.at(open) - placed.at({})) * (kUsualRange / kJawLight);
    return columns;
  }();
  return gain;
}

struct Worn {
  test::LinearRegressor* linear = nullptr;
  std::unique_ptr<EyewearTracker> tracker;
  Glasses glasses{kSensors};
  face::OutputFrame frame;
  std::size_t present = 0;
  std::optional<tracker::Explained> explained;
  float largest_step = 0;
  std::vector<tracker::CalibrationEvent> events;
  sensor::TimeLines lines{kSensors, test::glasses_rig(kSensors).find(test::glasses_rig(kSensors).reference)};

  void add(HostTime arrival, const sensor::Sample& sample) {
    lines.add(arrival, sample);
    tracker->add(arrival, sample);
  }

  Worn() {
    auto made = std::make_unique<test::LinearRegressor>(gain_m());
    linear = made.get();
    tracker =
        EyewearTracker::create(test::glasses_rig(kSensors), test::marked_mouth(), std::move(made)).value();
  }
  void play(double seconds, const Glasses::LogLight& light) {
    glasses.play(*this, seconds, light, [&](DeviceTime time) {
      const face::BlendshapeWeights before = frame.weights;
      tracker::TickResult result = tracker->tick(time, lines, frame);
      present = result.sensors_present;
      explained = result.explained;
      events.insert(events.end(), result.calibration.begin(), result.calibration.end());
      ASSERT_EQ(frame.time, time);
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        largest_step = std::max(largest_step, std::abs(frame.weights[k] - before[k]));
    });
  }
};

double rest(std::size_t, double) {
  return kNeutral;
}

/// A jaw that is `open` from 0 to 1.
Glasses::LogLight jaw(double open) {
  return [open](std::size_t s, double) { return kNeutral + (s == 0 ? kJawLight * open : 0); };
}

TEST(EyewearTracker, IsNeutralUntilItFindsANeutralByItself) {
  Worn worn;
  worn.play(1.5, rest);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::neutral);
  EXPECT_EQ(worn.present, kSensors) << "nothing is lost: nothing was there yet";
  EXPECT_EQ(worn.tracker->calibration_state().phase, tracker::CalibrationState::Phase::watching);
  EXPECT_EQ(worn.tracker->calibration_state().step, tracker::Step::neutral);
  EXPECT_NE(worn.tracker->calibration_state().hint, "");
  EXPECT_EQ(worn.tracker->calibration(), "");
  EXPECT_TRUE(worn.events.empty());
  worn.play(1, rest);
  ASSERT_EQ(worn.events.size(), 1u);
  EXPECT_EQ(worn.events[0].kind, tracker::CalibrationEvent::Kind::calibrated);
  EXPECT_EQ(worn.events[0].modality, "eyewear");
  EXPECT_EQ(worn.tracker->calibration_state().phase, tracker::CalibrationState::Phase::done);
  EXPECT_EQ(worn.tracker->calibration_state().hint, "");
  EXPECT_NE(worn.tracker->calibration(), "");
  ASSERT_EQ(worn.events[0].found.size(), 1u);
  EXPECT_EQ(worn.events[0].found[0].step, tracker::Step::neutral);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::measured);
  EXPECT_LT(worn.frame.weights[kJaw], 0.02F);
}

TEST(EyewearTracker, FollowsTheLightAndKnowsNothingOfTheHead) {
  Worn worn;
  worn.play(2.5, rest);
  for (const double open : {0.3, 0.8, 0.5}) {
    worn.play(1, jaw(open));
    EXPECT_NEAR(worn.frame.weights[kJaw], open, 0.05);
    EXPECT_EQ(worn.frame.confidence[kJaw], 1);
  }
  EXPECT_EQ(worn.present, kSensors);
  EXPECT_EQ(worn.frame.head_provenance, Provenance::neutral);
  EXPECT_EQ(worn.frame.head_confidence, 0);
  EXPECT_EQ(worn.frame.eyes_provenance, Provenance::neutral);
  EXPECT_EQ(worn.frame.eyes_confidence, 0);
  // Lids it sees, but not where the eyes look.
  EXPECT_EQ(worn.frame.provenance[face::shape("eyeBlink_L")], Provenance::measured);
  for (const char* gaze : {"eyeLookDown_L", "eyeLookIn_R", "eyeLookOut_L", "eyeLookUp_R"})
    EXPECT_EQ(worn.frame.provenance[face::shape_index(gaze)], Provenance::predicted) << gaze;
  EXPECT_EQ(worn.tracker->heading_sigma_rad(0), std::nullopt);
}

TEST(EyewearTracker, WhatItsSensorsExplainAndHowSureItIsFollowFromItsTable) {
  Worn worn;
  worn.play(2.5, rest);
  worn.play(1, jaw(0.6));
  ASSERT_TRUE(worn.explained);
  EXPECT_EQ((*worn.explained)[kJaw], 1);
  constexpr double kSilent = std::numeric_limits<double>::quiet_NaN();
  const auto open = jaw(0.6);
  worn.play(0.5, [&](std::size_t s, double t) { return s >= 2 ? kSilent : open(s, t); });
  EXPECT_EQ(worn.present, kSensors - 2);
  EXPECT_EQ(worn.frame.confidence[kJaw], 0.5F);
  EXPECT_EQ((*worn.explained)[kJaw], 0.5F);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::measured);
  EXPECT_NEAR(worn.frame.weights[kJaw], 0.6, 0.05);
  worn.play(0.5, [&](std::size_t, double) { return kSilent; });
  EXPECT_EQ(worn.present, 0u);
  EXPECT_EQ(worn.frame.confidence[kJaw], 0);
  EXPECT_EQ((*worn.explained)[kJaw], 0);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::predicted);
  worn.play(1, open);
  EXPECT_EQ(worn.present, kSensors);
  EXPECT_NEAR(worn.frame.weights[kJaw], 0.6, 0.05);
}

TEST(EyewearTracker, MeasuresNothingAndClaimsNothingWithoutATable) {
  auto made = std::make_unique<test::LinearRegressor>(gain_m());
  made->table.reset();
  Worn worn;
  worn.tracker =
      EyewearTracker::create(test::glasses_rig(kSensors), test::marked_mouth(), std::move(made)).value();
  worn.play(2.5, rest);
  worn.play(1, jaw(0.6));
  EXPECT_NEAR(worn.frame.weights[kJaw], 0.6, 0.05);
  EXPECT_EQ(worn.present, kSensors);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    EXPECT_EQ(worn.frame.provenance[k], Provenance::predicted);
    EXPECT_EQ(worn.frame.confidence[k], 0);
    EXPECT_EQ((*worn.explained)[k], 0);
  }
}

TEST(EyewearTracker, AGuidedRangeOfMotionMakesItsOwnMeasure) {
  Worn worn;
  worn.play(0.5, rest);
  const double begin_s = worn.glasses.now_s() + 0.5;
  worn.tracker->guide(tracker::Step::neutral, Glasses::at(begin_s), Glasses::at(begin_s + 5));
  worn.tracker->guide(tracker::Step::nod, Glasses::at(begin_s + 5), Glasses::at(begin_s + 6));
  worn.tracker->guide_range(Glasses::at(begin_s + 5), Glasses::at(begin_s + 45));
  worn.play(5.6, rest);
  EXPECT_EQ(worn.tracker->calibration_state().phase, tracker::CalibrationState::Phase::guided);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::measured) << "the neutral's end shows the face already";
  // This wearer's light changes by half as much.
  worn.play(40.5, [](std::size_t, double t) { return kNeutral + 0.25 * std::sin(3 * t); });
  EXPECT_EQ(worn.tracker->calibration_state().phase, tracker::CalibrationState::Phase::done);
  EXPECT_EQ(worn.tracker->calibration_state().hint, "");
  EXPECT_FALSE(worn.tracker->scores().empty());
  const Normalisation made = parse_normalisation(worn.tracker->calibration(), "test").value();
  EXPECT_NEAR(made.sensors[0].moved, 0.5, 0.02);
  EXPECT_LT(made.sensors[0].range, 0.7 * kUsualRange);

  // The glasses moved: a neutral alone.
  const auto moved = [](std::size_t s, double) { return kNeutral + 0.1 * static_cast<double>(s); };
  const double again_s = worn.glasses.now_s() + 0.5;
  worn.tracker->guide(tracker::Step::neutral, Glasses::at(again_s), Glasses::at(again_s + 5));
  worn.play(6, moved);
  const Normalisation remounted = parse_normalisation(worn.tracker->calibration(), "test").value();
  EXPECT_EQ(remounted.sensors[2].range, made.sensors[2].range);
  EXPECT_NEAR(remounted.sensors[2].neutral, kNeutral + 0.2, 1e-5);
}

TEST(EyewearTracker, WhatWasInForceComesBackWhenGuidanceIsCancelledOrFails) {
  Worn worn;
  worn.play(2.5, rest);
  const std::string before = worn.tracker->calibration();
  double begin_s = worn.glasses.now_s() + 0.1;
  worn.tracker->guide(tracker::Step::neutral, Glasses::at(begin_s), Glasses::at(begin_s + 1));
  worn.tracker->guide_range(Glasses::at(begin_s + 1), Glasses::at(begin_s + 9));
  worn.play(2, jaw(0.5));
  EXPECT_NE(worn.tracker->calibration(), before);
  worn.tracker->cancel_guidance();
  EXPECT_EQ(worn.tracker->calibration(), before);

  begin_s = worn.glasses.now_s() + 0.1;
  worn.tracker->guide(tracker::Step::neutral, Glasses::at(begin_s), Glasses::at(begin_s + 2));
  worn.play(
      3, [](std::size_t s, double) { return s < 3 ? std::numeric_limits<double>::quiet_NaN() : kNeutral; });
  EXPECT_EQ(worn.tracker->calibration(), before);
  EXPECT_NE(worn.tracker->calibration_state().hint, "");
  EXPECT_EQ(worn.events.back().kind, tracker::CalibrationEvent::Kind::withdrawn);
  EXPECT_EQ(worn.tracker->calibration_state().phase, tracker::CalibrationState::Phase::done);
}

TEST(EyewearTracker, AnotherBoardAtASensorsPlaceIsMissingUntilTheNextCalibration) {
  Worn worn;
  worn.play(2.5, rest);
  worn.tracker->forget(1);
  worn.play(0.5, rest);
  EXPECT_EQ(worn.present, kSensors - 1);
  for (std::uint16_t s = 0; s < kSensors; ++s) worn.tracker->forget(s);
  EXPECT_EQ(worn.tracker->calibration_state().phase, tracker::CalibrationState::Phase::watching);
  EXPECT_EQ(worn.tracker->calibration(), "");
}

TEST(EyewearTracker, RestoresACalibrationOfItsOwnSensorsOnly) {
  Worn worn;
  worn.play(2.5, rest);
  const std::string json = worn.tracker->calibration();
  Worn other;
  ASSERT_TRUE(other.tracker->restore(json));
  EXPECT_EQ(other.tracker->calibration(), json);
  other.play(1, jaw(0.6));
  EXPECT_NEAR(other.frame.weights[kJaw], 0.6, 0.05);

  EXPECT_EQ(other.tracker->restore("{}").error().code, ErrorCode::malformed);
  std::string renamed = json;
  renamed.replace(renamed.find("\"s2\""), 4, "\"t2\"");
  EXPECT_EQ(other.tracker->restore(renamed).error().code, ErrorCode::mismatch);
}

TEST(EyewearTracker, AnotherCalibrationForgetsTheRegressorsMemory) {
  Worn worn;
  worn.play(3, rest);
  EXPECT_EQ(worn.linear->resets, 1);
  ASSERT_TRUE(worn.tracker->restore(worn.tracker->calibration()));
  worn.play(0.5, rest);
  EXPECT_EQ(worn.linear->resets, 2);
}

TEST(EyewearTracker, FollowsADriftingLightWhereTheRigAsksForIt) {
  sensor::Rig rig = test::glasses_rig(kSensors);
  rig.sensors[0].recentre = true;
  Worn left, followed;
  followed.tracker =
      EyewearTracker::create(rig, test::marked_mouth(), std::make_unique<test::LinearRegressor>(gain_m()))
          .value();
  const auto slipped = [](std::size_t s, double t) {
    return kNeutral + (s == 0 ? 0.3 * kJawLight * std::min(t / 30, 1.0) : 0);
  };
  for (Worn* worn : {&left, &followed}) {
    worn->play(2.5, rest);
    worn->play(80, slipped);
  }
  EXPECT_NEAR(left.frame.weights[kJaw], 0.3, 0.05);
  EXPECT_NEAR(followed.frame.weights[kJaw], 0, 0.05);
  // Another neutral begins anew.
  const double begin_s = followed.glasses.now_s() + 0.1;
  followed.tracker->guide(tracker::Step::neutral, Glasses::at(begin_s), Glasses::at(begin_s + 2));
  followed.play(3, rest);
  followed.play(1, jaw(0.6));
  EXPECT_NEAR(followed.frame.weights[kJaw], 0.6, 0.05);
}

TEST(EyewearTracker, TheSameCallsGiveTheSameBits) {
  Worn one, other;
  for (Worn* worn : {&one, &other}) {
    worn->play(2.5, rest);
    worn->play(
        2, [](std::size_t s, double t) { return kNeutral + 0.3 * std::sin(2 * t + static_cast<double>(s)); });
  }
  EXPECT_EQ(one.frame.weights, other.frame.weights);
}

TEST(EyewearTracker, RefusesAModelOfOtherMarkersAndARigWithoutEyes) {
  const auto made = [](const sensor::Rig& rig, Eigen::Index rows) {
    return EyewearTracker::create(
        rig, test::marked_mouth(),
        std::make_unique<test::LinearRegressor>(Eigen::MatrixXd::Zero(rows, kSensors)));
  };
  EXPECT_EQ(made(test::glasses_rig(kSensors), 6).error().code, ErrorCode::mismatch);
  sensor::Rig imus = test::glasses_rig(kSensors);
  for (sensor::Mount& mount : imus.sensors) mount.kind = "imu";
  EXPECT_EQ(made(imus, gain_m().rows()).error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::eyewear::eyewear_tracker_test
