#include "mien/shaping/lids.h"

#include <gtest/gtest.h>

#include "mien/shaping/eyes.h"
#include "mien/shaping/shaper.h"
#include "tests/shaping/frames.h"

namespace mien::shaping::lids_test {
namespace {

using face::Provenance;
using face::shape;

/// A frame of somebody whose eyes are seen, and whose lids are guessed: 0.5 for every eyeLook shape.
face::OutputFrame looking(std::int64_t index, float yaw, float pitch) {
  face::OutputFrame frame = measured(index);
  for (const EyeShapes& eye : kEyeShapes)
    for (const std::size_t i : {eye.left, eye.right, eye.up, eye.down}) {
      frame.weights[i] = 0.5F;
      frame.confidence[i] = 0.1F;
      frame.provenance[i] = Provenance::predicted;
    }
  frame.eyes_rad = {Eigen::Vector2f(yaw, pitch), Eigen::Vector2f(yaw, pitch)};
  frame.eyes_provenance = Provenance::measured;
  frame.eyes_confidence = 0.75F;
  return frame;
}

void apply(Lids& lids, face::OutputFrame& frame, bool follow = true) {
  lids.apply(frame, follow, 0.3);
}

TEST(Lids, FollowEachEyeByItself) {
  Lids lids;
  face::OutputFrame frame = looking(0, 0, 0);
  // 0.611 rad is 1: a quarter of it to the performer's left is 0.25; more than all of it is capped.
  frame.eyes_rad[0] = {0.15275F, -0.3055F};
  frame.eyes_rad[1] = {-0.9F, 0.0611F};
  apply(lids, frame);
  EXPECT_FLOAT_EQ(frame.weights[shape("eyeLookOut_L")], 0.25F);
  EXPECT_EQ(frame.weights[shape("eyeLookIn_L")], 0);
  EXPECT_EQ(frame.weights[shape("eyeLookUp_L")], 0);
  EXPECT_FLOAT_EQ(frame.weights[shape("eyeLookDown_L")], 0.5F);
  EXPECT_EQ(frame.weights[shape("eyeLookIn_R")], 0);
  EXPECT_EQ(frame.weights[shape("eyeLookOut_R")], 1);
  EXPECT_FLOAT_EQ(frame.weights[shape("eyeLookUp_R")], 0.1F);
  EXPECT_EQ(frame.weights[shape("eyeLookDown_R")], 0);
  for (const EyeShapes& eye : kEyeShapes)
    for (const std::size_t i : {eye.left, eye.right, eye.up, eye.down}) {
      EXPECT_EQ(frame.confidence[i], 0.75F) << face::kShapeNames[i];
      EXPECT_EQ(frame.provenance[i], Provenance::measured) << face::kShapeNames[i];
    }
  EXPECT_EQ(frame.weights[shape("eyeBlink_L")], 0);
  EXPECT_EQ(frame.confidence[shape("eyeBlink_L")], 0.9F);
}

TEST(Lids, WhatWasSeenOfAnEyesLidsStays) {
  for (const Provenance seen : {Provenance::measured, Provenance::interpolated}) {
    Lids lids;
    face::OutputFrame frame = looking(0, 0.611F, 0);
    frame.provenance[shape("eyeLookDown_L")] = seen;
    apply(lids, frame);
    EXPECT_EQ(frame.weights[shape("eyeLookOut_L")], 0.5F);
    EXPECT_EQ(frame.provenance[shape("eyeLookOut_L")], Provenance::predicted);
    EXPECT_FLOAT_EQ(frame.weights[shape("eyeLookIn_R")], 1);
    EXPECT_EQ(frame.weights[shape("eyeLookOut_R")], 0);
  }
}

TEST(Lids, WithoutATrackersDirectionsNoBitChanges) {
  Lids lids;
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    face::OutputFrame frame = moving(i, random);
    if (i % 2 == 0) frame.provenance.fill(Provenance::predicted);
    const face::OutputFrame before = frame;
    apply(lids, frame);
    ASSERT_TRUE(same_bits(before, frame)) << i;
  }
}

TEST(Lids, CanBeLeftToTheirTracker) {
  ShaperSettings settings;
  settings.lids_follow_eyes = false;
  Shaper left(settings), following;
  face::OutputFrame frame = looking(0, 0.3055F, 0), followed = frame;
  left.apply(frame, 1);
  following.apply(followed, 1);
  EXPECT_EQ(frame.weights[shape("eyeLookOut_L")], 0.5F);
  EXPECT_EQ(frame.weights[shape("eyeLookUp_L")], 0.5F);
  EXPECT_EQ(followed.weights[shape("eyeLookUp_L")], 0);
  EXPECT_EQ(followed.eyes_rad[0].x(), 0.3055F);
}

TEST(Lids, ChangeHandsWithoutAJump) {
  Lids lids;
  const auto nobody_looks = [](std::int64_t i) {
    face::OutputFrame frame = looking(i, 0, 0);
    frame.eyes_provenance = Provenance::neutral;
    frame.eyes_confidence = 0;
    return frame;
  };
  face::OutputFrame before = nobody_looks(0);
  apply(lids, before);
  double most = 0;
  for (int i = 1; i < 300; ++i) {
    face::OutputFrame frame = i < 150 ? looking(i, 0.611F, 0) : nobody_looks(i);
    apply(lids, frame);
    most = std::max(most, largest_step(before, frame));
    if (i == 149) {
      EXPECT_FLOAT_EQ(frame.weights[shape("eyeLookOut_L")], 1);
      EXPECT_EQ(frame.weights[shape("eyeLookUp_L")], 0);
    }
    before = frame;
  }
  EXPECT_FLOAT_EQ(before.weights[shape("eyeLookOut_L")], 0.5F);
  // 0.097 of the offset of 0.5 a frame (docs/method/shaping.md).
  EXPECT_LT(most, 0.05);
  EXPECT_GT(most, 0.04);
}

TEST(Lids, HeldDirectionsTakeNothingFromHeldLids) {
  Lids lids;
  face::OutputFrame frame = looking(0, 0.611F, 0);
  frame.provenance.fill(Provenance::measured);
  apply(lids, frame);
  for (int i = 1; i < 10; ++i) {
    frame = looking(i, 0.611F, 0);
    frame.provenance.fill(Provenance::held);
    frame.eyes_provenance = Provenance::held;
    apply(lids, frame);
    ASSERT_EQ(frame.weights[shape("eyeLookOut_L")], 0.5F);
  }
}

TEST(Lids, GoBackToNeutralWithTheEyesWhenSensorsAreLost) {
  Shaper shaper;
  face::OutputFrame before;
  for (int i = 0; i < 180; ++i) {
    face::OutputFrame frame = looking(i, 0.611F, 0);
    shaper.apply(frame, i < 60 ? 3 : 0);
    if (i > 0) {
      ASSERT_LT(largest_step(before, frame), 0.06) << i;
    }
    if (i == 65) {
      EXPECT_FLOAT_EQ(frame.weights[shape("eyeLookOut_L")], 1);
    }
    before = frame;
  }
  EXPECT_EQ(before.weights, face::BlendshapeWeights{});
  EXPECT_EQ(before.provenance[shape("eyeLookOut_L")], Provenance::neutral);
}

TEST(Lids, FitTheEyesWhateverGainsAndSmoothingAsk) {
  ShaperSettings settings;
  settings.smoothing = 1;
  settings.limits.shapes[shape("eyeLookOut_L")].gain = 0.5F;
  Shaper shaper(settings);
  for (int i = 0; i < 60; ++i) {
    face::OutputFrame frame = looking(i, i % 2 == 0 ? 0.611F : 0, 0);
    shaper.apply(frame, 1);
    ASSERT_FLOAT_EQ(frame.weights[shape("eyeLookOut_L")], i % 2 == 0 ? 1 : 0);
    ASSERT_FLOAT_EQ(frame.weights[shape("eyeLookIn_R")], i % 2 == 0 ? 1 : 0);
  }
}

}  // namespace
}  // namespace mien::shaping::lids_test
