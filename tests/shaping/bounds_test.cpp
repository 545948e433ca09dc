#include "mien/shaping/bounds.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/shaping/frames.h"

namespace mien::shaping::bounds_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

TEST(Mend, ChangesNoBitOfAFrameThatIsWell) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const face::OutputFrame in = moving(i, random);
    face::OutputFrame out = in;
    mend(out, face::neutral_frame({}));
    EXPECT_TRUE(same_bits(in, out));
  }
}

TEST(Mend, ARegionOfWhichAWeightIsNoNumberIsUnknown) {
  face::OutputFrame frame = measured(1, 0.6f);
  frame.region_confidence = {0.5f, kNan, 7, -1, 0.25f};
  frame.weights[face::shape("jawOpen")] = kNan;
  mend(frame, face::neutral_frame({}));
  EXPECT_EQ(frame.region_confidence, (std::array<float, 5>{0.5f, 0, 1, 0, 0}));
}

TEST(Mend, TakesTheLastValueForOneThatIsNoNumber) {
  const face::OutputFrame last = measured(0, 0.4f);
  face::OutputFrame frame = measured(1, 0.6f);
  frame.weights[3] = kNan;
  frame.weights[4] = -kInf;
  frame.confidence[5] = kNan;
  frame.confidence[6] = 7;
  mend(frame, last);
  for (const std::size_t i : {3, 4}) {
    EXPECT_EQ(frame.weights[i], 0.4f);
    EXPECT_EQ(frame.confidence[i], 0);
    EXPECT_EQ(frame.provenance[i], face::Provenance::held);
  }
  EXPECT_EQ(frame.confidence[5], 0);
  EXPECT_EQ(frame.confidence[6], 1);
  EXPECT_EQ(frame.weights[5], 0.6f);
}

TEST(Mend, BringsWeightsIntoTheirRange) {
  face::OutputFrame frame = measured(1, 0.6f);
  frame.weights[3] = 1.2f;
  frame.weights[4] = -0.1f;
  mend(frame, face::neutral_frame({}));
  EXPECT_EQ(frame.weights[3], 1.0f);
  EXPECT_EQ(frame.weights[4], 0.0f);
}

TEST(Mend, RepairsHeadAndEyes) {
  face::OutputFrame last = measured(0);
  last.head = exp_rotation({0.1, 0.2, 0.3});
  last.eyes_rad[1] = {0.1f, 0.2f};
  face::OutputFrame frame = measured(1);
  frame.head = Quat(0, 0, 0, 0);
  frame.eyes_rad[0] = {kNan, 0};
  frame.eyes_confidence = 1;
  mend(frame, last);
  EXPECT_EQ(frame.head.coeffs(), last.head.coeffs());
  EXPECT_EQ(frame.head_confidence, 0);
  EXPECT_EQ(frame.head_provenance, face::Provenance::held);
  EXPECT_EQ(frame.eyes_rad[1], last.eyes_rad[1]);
  EXPECT_EQ(frame.eyes_confidence, 0);

  frame = measured(2);
  frame.head = Quat(1.05, 0, 0, 0);
  frame.eyes_rad[0] = {9, -9};
  mend(frame, last);
  EXPECT_EQ(frame.head.coeffs(), Quat::Identity().coeffs());
  EXPECT_NEAR(frame.eyes_rad[0].x(), std::numbers::pi / 2, 1e-6);
}

TEST(Bound, HoldsTheRange) {
  face::OutputFrame frame = measured(0, 0.5f);
  frame.weights[0] = kNan;
  frame.weights[1] = kInf;
  frame.weights[2] = -kInf;
  frame.tongue_out = 2;
  bound(frame);
  EXPECT_EQ(frame.weights[0], 0);
  EXPECT_EQ(frame.weights[1], 1);
  EXPECT_EQ(frame.weights[2], 0);
  EXPECT_EQ(frame.weights[3], 0.5f);
  EXPECT_EQ(frame.tongue_out, 1);
}

TEST(NeutralFrame, SaysThatItIsNeutral) {
  const face::OutputFrame frame = face::neutral_frame(frame_time(3));
  EXPECT_EQ(frame.time, frame_time(3));
  for (const face::Provenance p : frame.provenance) EXPECT_EQ(p, face::Provenance::neutral);
  EXPECT_EQ(frame.weights, face::BlendshapeWeights{});
}

TEST(BoundSteps, ALargeStepTakesTwoFramesAndASmallOneKeepsItsBits) {
  face::OutputFrame before = face::neutral_frame(DeviceTime{});
  before.weights[3] = 0.1f;
  face::OutputFrame frame = face::neutral_frame(DeviceTime(frame_offset(1)));
  frame.weights[3] = 0.95f;
  frame.weights[4] = 0.4321f;
  frame.tongue_out = 1;
  face::OutputFrame late = frame;
  bound_steps(frame, before);
  EXPECT_NEAR(frame.weights[3], 0.6, 1e-4);
  EXPECT_EQ(frame.weights[4], 0.4321f);
  EXPECT_NEAR(frame.tongue_out, 0.5, 1e-4);
  late.time = DeviceTime(frame_offset(2));
  bound_steps(late, before);
  EXPECT_EQ(late.weights[3], 0.95f);
}

TEST(Mend, RepairsTheHeadsPosition) {
  const face::OutputFrame last = standing_at(0, {0.1F, 0.2F, 0.3F});
  face::OutputFrame frame = standing_at(1, {0, kNan, 0});
  mend(frame, last);
  EXPECT_EQ(frame.head_position_m, last.head_position_m);
  EXPECT_TRUE(frame.head_position_known);
  EXPECT_EQ(frame.head_provenance, face::Provenance::held);
  EXPECT_EQ(frame.head_confidence, 0);
  frame = standing_at(1, {-1e30F, 0.5F, kInf});
  mend(frame, measured(0));
  EXPECT_FALSE(frame.head_position_known);
  EXPECT_EQ(frame.head_position_m, Vec3f(0, 0, 0));
  frame = standing_at(1, {-1e30F, 0.5F, 11});
  mend(frame, last);
  EXPECT_EQ(frame.head_position_m, Vec3f(-kHeadAtMost_m, 0.5F, kHeadAtMost_m));
  EXPECT_EQ(frame.head_provenance, face::Provenance::measured);
  // One that is not known is nowhere.
  frame = standing_at(1, {kNan, 1, 2});
  frame.head_position_known = false;
  mend(frame, last);
  EXPECT_EQ(frame.head_position_m, Vec3f(0, 0, 0));
  EXPECT_EQ(frame.head_provenance, face::Provenance::measured);
}

}  // namespace
}  // namespace mien::shaping::bounds_test
