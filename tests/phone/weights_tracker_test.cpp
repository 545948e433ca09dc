#include "mien/phone/weights_tracker.h"

#include <gtest/gtest.h>

namespace mien::phone::weights_tracker_test {
namespace {

using face::Provenance;
using face::shape;

const std::size_t kJaw = shape("jawOpen");
const std::size_t kPuff = shape("cheekPuff_L");

/// Two senders, whose clocks are the session's.
sensor::Rig two() {
  sensor::Rig rig{.name = "two", .reference = "a"};
  for (const char* name : {"a", "b"})
    rig.sensors.push_back({.name = name, .kind = "weights", .role = "face"});
  return rig;
}

class Played {
 public:
  void tell(std::uint16_t sensor, int ms, const ToldFace& face, int arrival_ms = -1) {
    std::array<sensor::Sample, kMostParts> samples;
    const std::size_t used = samples_of(face, samples);
    const HostTime arrival{std::chrono::milliseconds(arrival_ms < 0 ? ms : arrival_ms)};
    ++sequence_;
    for (sensor::Sample& sample : std::span(samples).first(used)) {
      sample.sensor = sensor;
      sample.sequence = sequence_;
      sample.time = DeviceTime(std::chrono::milliseconds(ms));
      lines_.add(arrival, sample);
      tracker_->add(arrival, sample);
    }
  }
  face::OutputFrame frame(int ms) {
    face::OutputFrame out;
    const auto result = tracker_->tick(DeviceTime(std::chrono::milliseconds(ms)), lines_, out);
    present = result.sensors_present;
    return out;
  }
  std::size_t present = 0;
  WeightsTracker& tracker() { return *tracker_; }

 private:
  std::unique_ptr<WeightsTracker> tracker_ = WeightsTracker::create(two()).value();
  sensor::TimeLines lines_{2, std::uint16_t{0}};
  std::uint32_t sequence_ = 0;
};

ToldFace jaw(float weight, float confidence = kUntold) {
  ToldFace face;
  face.set = ShapeSet::arkit52;
  face.origin = Origin::measured;
  face.weights[17] = weight;
  face.confidence[17] = confidence;
  return face;
}

ToldFace at(const Vec3f& position_m, double yaw_rad = 0) {
  ToldFace face;
  face.origin = Origin::measured;
  face.head = ToldHead{.position_m = position_m, .position_known = true};
  face.head->rotation = {static_cast<float>(std::cos(yaw_rad / 2)), 0,
                         static_cast<float>(std::sin(yaw_rad / 2)), 0};
  return face;
}

TEST(WeightsTracker, TellsWhatIsToldAndNothingElse) {
  Played played;
  played.tell(0, 1000, jaw(0.5F, 0.75F));
  const face::OutputFrame frame = played.frame(1010);
  EXPECT_EQ(played.present, 1U);
  EXPECT_EQ(frame.weights[kJaw], 0.5F);
  EXPECT_EQ(frame.confidence[kJaw], 0.75F);
  EXPECT_EQ(frame.provenance[kJaw], Provenance::measured);
  EXPECT_EQ(std::ranges::count(frame.provenance, Provenance::neutral), 52);
  EXPECT_EQ(frame.head_provenance, Provenance::neutral);
  EXPECT_FALSE(frame.head_position_known);
  EXPECT_EQ(frame.eyes_provenance, Provenance::neutral);
}

TEST(WeightsTracker, AnswersBetweenItsSamples) {
  Played played;
  played.tell(0, 1000, jaw(0.25F));
  played.tell(0, 1040, jaw(0.75F));
  EXPECT_NEAR(played.frame(1010).weights[kJaw], 0.375, 1e-6);
  EXPECT_EQ(played.frame(1050).weights[kJaw], 0.75F);
  // A gap is not bridged.
  played.tell(0, 1300, jaw(0));
  EXPECT_EQ(played.frame(1200).weights[kJaw], 0.75F);
  // What only one of the two tells is not mixed with what the other does not.
  ToldFace other;
  other.set = ShapeSet::arkit52;
  other.weights[46] = 1;
  played.tell(0, 1320, other);
  const face::OutputFrame frame = played.frame(1310);
  EXPECT_EQ(frame.weights[kJaw], 0);
  EXPECT_EQ(frame.provenance[kPuff], Provenance::neutral);
}

TEST(WeightsTracker, OfTwoTheSurerOneOfEachShapeAnswers) {
  Played played;
  played.tell(0, 1000, jaw(0.25F, 0.5F));
  ToldFace other = jaw(0.75F, 0.75F);
  other.weights[46] = 0.125F;
  other.origin = Origin::audio;
  played.tell(1, 1000, other);
  face::OutputFrame frame = played.frame(1000);
  EXPECT_EQ(played.present, 2U);
  EXPECT_EQ(frame.weights[kJaw], 0.75F);
  EXPECT_EQ(frame.provenance[kJaw], Provenance::audio);
  EXPECT_EQ(frame.weights[kPuff], 0.125F);
  EXPECT_EQ(frame.confidence[kPuff], kDefaultConfidence);
  played.tell(1, 1010, jaw(1, 0.5F));
  frame = played.frame(1020);
  EXPECT_EQ(frame.weights[kJaw], 0.25F) << "the first of equals";
}

TEST(WeightsTracker, TheHeadCountsFromWhereItWasFirst) {
  Played played;
  played.tell(0, 1000, at({1, 2, 3}));
  played.tell(0, 1020, at({1.5F, 2, 3.25F}, 0.5));
  face::OutputFrame frame = played.frame(1000);
  EXPECT_TRUE(frame.head_position_known);
  EXPECT_EQ(frame.head_position_m, Vec3f(0, 0, 0));
  EXPECT_EQ(frame.head_provenance, Provenance::measured);
  EXPECT_EQ(frame.head_confidence, kDefaultConfidence);
  EXPECT_EQ(std::ranges::count(frame.provenance, Provenance::neutral), 53);
  frame = played.frame(1010);
  EXPECT_LT((frame.head_position_m - Vec3f(0.25F, 0, 0.125F)).norm(), 1e-6);
  EXPECT_LT(angle_between(frame.head, exp_rotation({0, 0.25, 0})), 1e-6);
  // Another device in its place has another world.
  played.tracker().forget(0);
  played.tell(0, 1040, at({-7, 0, 0}));
  EXPECT_EQ(played.frame(1050).head_position_m, Vec3f(0, 0, 0));
}

TEST(WeightsTracker, AHeadWithoutAPositionTurnsOnly) {
  Played played;
  ToldFace face = at({0, 0, 0}, 0.5);
  face.head->position_known = false;
  played.tell(0, 1000, face);
  const face::OutputFrame frame = played.frame(1000);
  EXPECT_LT(angle_between(frame.head, exp_rotation({0, 0.5, 0})), 1e-6);
  EXPECT_FALSE(frame.head_position_known);
}

TEST(WeightsTracker, ASenderThatBeginsAnewGoesOnWhereTheHeadWas) {
  Played played;
  played.tell(0, 10000, at({0, 0, 0}));
  played.tell(0, 10020, at({0.25F, 0, 0}));
  EXPECT_EQ(played.frame(10030).head_position_m.x(), 0.25F);
  for (int ms = 0; ms < 3000; ms += 20) played.tell(0, ms, at({5, 1, 0}), 10500 + ms);
  const face::OutputFrame frame = played.frame(13490);
  EXPECT_EQ(played.present, 1U);
  EXPECT_LT((frame.head_position_m - Vec3f(0.25F, 0, 0)).norm(), 1e-6);
  // Samples that run back a little are dropped.
  played.tell(0, 2970, at({9, 9, 9}), 13495);
  EXPECT_EQ(played.frame(13500).head_position_m, frame.head_position_m);
}

TEST(WeightsTracker, AFaceThatIsHeldIsNotSure) {
  Played played;
  ToldFace face = jaw(0.5F, 1);
  face.origin = Origin::held;
  face.head = ToldHead{.confidence = 1};
  played.tell(0, 1000, face);
  const face::OutputFrame frame = played.frame(1000);
  EXPECT_EQ(frame.provenance[kJaw], Provenance::held);
  EXPECT_EQ(frame.confidence[kJaw], 0);
  EXPECT_EQ(frame.head_provenance, Provenance::held);
  EXPECT_EQ(frame.head_confidence, 0);
}

TEST(WeightsTracker, IsAbsentWithoutSamplesAndForgets) {
  Played played;
  EXPECT_EQ(played.frame(900).provenance[kJaw], Provenance::neutral);
  EXPECT_EQ(played.present, 0U);
  played.tell(0, 1000, jaw(1));
  static_cast<void>(played.frame(1200));
  EXPECT_EQ(played.present, 1U);
  EXPECT_EQ(played.frame(1201).provenance[kJaw], Provenance::neutral);
  EXPECT_EQ(played.present, 0U);
  played.tell(0, 1300, jaw(1));
  played.tracker().forget(0);
  static_cast<void>(played.frame(1310));
  EXPECT_EQ(played.present, 0U);
}

TEST(WeightsTracker, TheTongueComesToo) {
  Played played;
  ToldFace face = jaw(0.5F);
  face.weights[51] = 0.25F;
  played.tell(0, 1000, face);
  EXPECT_EQ(played.frame(1000).tongue_out, 0.25F);
}

TEST(WeightsTracker, HasNothingToCalibrateAndWantsASensorOfItsKind) {
  Played played;
  EXPECT_EQ(played.tracker().calibration_state().phase, tracker::CalibrationState::Phase::done);
  EXPECT_EQ(played.tracker().calibration(), "");
  EXPECT_FALSE(played.tracker().restore("{}"));
  sensor::Rig rig = two();
  for (sensor::Mount& mount : rig.sensors) mount.kind = "imu";
  EXPECT_EQ(WeightsTracker::create(rig).error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::phone::weights_tracker_test
