#include "mien/gaze/gaze_tracker.h"

#include <gtest/gtest.h>

namespace mien::gaze::gaze_tracker_test {
namespace {

using face::Provenance;
using face::shape;

/// Two senders, whose clocks are the session's.
sensor::Rig two() {
  sensor::Rig rig{.name = "two", .reference = "a"};
  for (const char* name : {"a", "b"}) rig.sensors.push_back({.name = name, .kind = "gaze", .role = "face"});
  return rig;
}

class Played {
 public:
  void see(std::uint16_t sensor, int ms, const Eyes& eyes, int arrival_ms = -1) {
    sensor::Sample sample = sample_of(eyes);
    sample.sensor = sensor;
    sample.time = DeviceTime(std::chrono::milliseconds(ms));
    const HostTime arrival{std::chrono::milliseconds(arrival_ms < 0 ? ms : arrival_ms)};
    lines_.add(arrival, sample);
    tracker_->add(arrival, sample);
  }
  face::OutputFrame frame(int ms) {
    face::OutputFrame out;
    const auto result = tracker_->tick(DeviceTime(std::chrono::milliseconds(ms)), lines_, out);
    present = result.sensors_present;
    return out;
  }
  std::size_t present = 0;
  GazeTracker& tracker() { return *tracker_; }

 private:
  std::unique_ptr<GazeTracker> tracker_ = GazeTracker::create(two()).value();
  sensor::TimeLines lines_{2, std::uint16_t{0}};
};

Eyes looking(float yaw, float left_confidence, float right_confidence) {
  return {Eye{.yaw_rad = yaw, .pitch_rad = 0.1F, .confidence = left_confidence},
          Eye{.yaw_rad = yaw + 0.05F, .pitch_rad = 0.1F, .confidence = right_confidence}};
}

TEST(GazeTracker, GivesTheNewestDirectionsNotAfterTheFrame) {
  Played played;
  played.see(0, 1000, looking(0.1F, 1, 0.5F));
  played.see(0, 1020, looking(0.2F, 1, 0.5F));
  const face::OutputFrame frame = played.frame(1010);
  EXPECT_EQ(played.present, 1U);
  EXPECT_EQ(frame.eyes_rad[0], Eigen::Vector2f(0.1F, 0.1F));
  EXPECT_EQ(frame.eyes_rad[1].x(), 0.1F + 0.05F);
  EXPECT_EQ(frame.eyes_provenance, Provenance::measured);
  EXPECT_EQ(frame.eyes_confidence, 0.75F);
  EXPECT_EQ(frame.provenance[shape("eyeBlink_L")], Provenance::neutral) << "openness is not known";
  EXPECT_EQ(frame.head_provenance, Provenance::neutral);
  EXPECT_EQ(played.frame(1025).eyes_rad[0].x(), 0.2F);
}

TEST(GazeTracker, OfTwoSensorsTheSurerOneOfEachEyeAnswers) {
  Played played;
  played.see(0, 1000, looking(0.1F, 0.9F, 0.2F));
  played.see(1, 1000, looking(0.3F, 0.5F, 0.7F));
  const face::OutputFrame frame = played.frame(1010);
  EXPECT_EQ(played.present, 2U);
  EXPECT_EQ(frame.eyes_rad[0].x(), 0.1F);
  EXPECT_EQ(frame.eyes_rad[1].x(), 0.3F + 0.05F);
}

TEST(GazeTracker, AnEyeThatIsNotSeenTurnsWithTheOther) {
  Played played;
  played.see(0, 1000, looking(0.2F, 1, 0));
  const face::OutputFrame frame = played.frame(1010);
  EXPECT_EQ(frame.eyes_rad[1].x(), 0.2F);
  EXPECT_EQ(frame.eyes_confidence, 0.5F);
}

TEST(GazeTracker, ABlinkClosesTheLidsAndHoldsTheEyes) {
  Played played;
  played.see(0, 1000, looking(0.2F, 1, 1));
  static_cast<void>(played.frame(1010));
  Eyes closed = looking(0.9F, 0, 0);
  closed[0].openness = closed[1].openness = 0.25F;
  played.see(0, 1020, closed);
  const face::OutputFrame frame = played.frame(1030);
  EXPECT_EQ(frame.weights[shape("eyeBlink_L")], 0.75F);
  EXPECT_EQ(frame.provenance[shape("eyeBlink_R")], Provenance::measured);
  EXPECT_EQ(frame.confidence[shape("eyeBlink_R")], 1);
  EXPECT_EQ(frame.eyes_rad[0].x(), 0.2F);
  EXPECT_EQ(frame.eyes_provenance, Provenance::held);
  EXPECT_EQ(frame.eyes_confidence, 0);
}

TEST(GazeTracker, IsAbsentWithoutSamplesAndForgets) {
  Played played;
  EXPECT_EQ(played.frame(900).eyes_provenance, Provenance::neutral);
  EXPECT_EQ(played.present, 0U);
  played.see(0, 1000, looking(0.2F, 1, 1));
  static_cast<void>(played.frame(1200));
  EXPECT_EQ(played.present, 1U);
  EXPECT_EQ(played.frame(1201).eyes_provenance, Provenance::neutral);
  EXPECT_EQ(played.present, 0U);
  played.see(0, 1300, looking(0.2F, 1, 1));
  played.tracker().forget(0);
  static_cast<void>(played.frame(1310));
  EXPECT_EQ(played.present, 0U);
}

TEST(GazeTracker, SamplesThatRunBackAreDroppedButThoseOfARestart) {
  Played played;
  played.see(0, 10000, looking(0.1F, 1, 1));
  played.see(0, 9990, looking(0.2F, 1, 1), 10001);
  EXPECT_EQ(played.frame(10001).eyes_rad[0].x(), 0.1F);
  // A sender that begins anew at 0 goes on where the line is.
  for (int ms = 0; ms < 3000; ms += 20) played.see(0, ms, looking(0.3F, 1, 1), 10500 + ms);
  EXPECT_EQ(played.frame(13490).eyes_rad[0].x(), 0.3F);
  EXPECT_EQ(played.present, 1U);
}

TEST(GazeTracker, HasNothingToCalibrate) {
  Played played;
  EXPECT_EQ(played.tracker().calibration_state().phase, tracker::CalibrationState::Phase::done);
  EXPECT_EQ(played.tracker().calibration(), "");
  EXPECT_FALSE(played.tracker().restore("{}"));
}

TEST(GazeTracker, WantsASensorOfItsKind) {
  sensor::Rig rig = two();
  for (sensor::Mount& mount : rig.sensors) mount.kind = "imu";
  EXPECT_EQ(GazeTracker::create(rig).error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::gaze::gaze_tracker_test
