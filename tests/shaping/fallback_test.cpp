#include "mien/shaping/fallback.h"
#include "mien/core/smoothstep.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/shaping/frames.h"

namespace mien::shaping::fallback_test {
namespace {

using face::Provenance;

TEST(Ease, BeginsAndEndsAtRestWithinItsEnds) {
  EXPECT_EQ(smoothstep(-1), 0);
  EXPECT_EQ(smoothstep(0), 0);
  EXPECT_EQ(smoothstep(0.5), 0.5);
  EXPECT_EQ(smoothstep(1), 1);
  EXPECT_EQ(smoothstep(std::numeric_limits<double>::infinity()), 1);
  for (int i = 0; i < 100; ++i) {
    EXPECT_GT(smoothstep((i + 1) / 100.0), smoothstep(i / 100.0));
    EXPECT_LE(smoothstep((i + 1) / 100.0) - smoothstep(i / 100.0), 0.015 + 1e-12);
  }
}

TEST(Fallback, KeepsEveryBitWhileNothingIsLost) {
  Fallback fallback;
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const face::OutputFrame in = moving(i, random);
    face::OutputFrame out = in;
    fallback.apply(out, 12);
    ASSERT_TRUE(same_bits(in, out));
  }
}

TEST(Fallback, IsNeutralBeforeTheFirstSensor) {
  Fallback fallback;
  for (int i = 0; i < 100; ++i) {
    face::OutputFrame out = measured(i, 0.7f);
    fallback.apply(out, 0);
    ASSERT_EQ(out.weights, face::BlendshapeWeights{});
    ASSERT_EQ(out.provenance[3], Provenance::neutral);
    ASSERT_EQ(out.confidence[3], 0);
    ASSERT_EQ(out.head_provenance, Provenance::neutral);
  }
}

TEST(Fallback, HoldsThenEasesToNeutral) {
  Fallback fallback({.hold_s = 0.3, .neutral_s = 0.5, .return_s = 0.3});
  face::OutputFrame good = measured(0, 0.8f);
  good.head = exp_rotation({0, 0.6, 0}) * exp_rotation({0.3, 0, 0.1});
  good.eyes_rad[0] = {0.3f, -0.2f};
  good.eyes_rad[1] = {0.25f, -0.2f};
  good.eyes_confidence = 0.5f;
  good.eyes_provenance = Provenance::measured;
  fallback.apply(good, 3);
  const Quat head = good.head;
  face::OutputFrame before = good;
  for (int i = 1; i <= 120; ++i) {
    face::OutputFrame out = measured(i, 0.1f);  // What the tracker makes up is not shown.
    fallback.apply(out, 0);
    const double age = i / 60.0;
    const double expected = 0.8 * (1 - smoothstep((age - 0.3) / 0.5));
    ASSERT_NEAR(out.weights[7], expected, 1e-6) << i;
    if (i != 18) {
      ASSERT_EQ(out.provenance[7], i < 18 ? Provenance::held : Provenance::neutral) << i;
    }
    ASSERT_NEAR(out.confidence[7], 0.9 * std::max(0.0, 1 - age / 0.8), 1e-6);
    ASSERT_LE(out.confidence[7], before.confidence[7]);
    ASSERT_LE(largest_step(out, before), 0.05 * 0.8 + 1e-6);
    ASSERT_LE(angle_between(out.head, before.head), 0.05 * 0.4);
    if (i <= 18) {
      ASSERT_LT(angle_between(out.head, head), 1e-7);
    }
    before = out;
  }
  EXPECT_EQ(before.weights, face::BlendshapeWeights{});
  EXPECT_LT(angle_between(before.head, twist_about(head, Vec3::UnitY())), 1e-9);
  EXPECT_GT(angle_between(before.head, Quat::Identity()), 0.5);  // Its yaw is kept.
  EXPECT_EQ(before.eyes_rad[0].norm(), 0);
  EXPECT_EQ(before.head_confidence, 0);
  EXPECT_EQ(before.eyes_provenance, Provenance::neutral);
}

TEST(Fallback, NeutralIsNotCalledHeld) {
  Fallback fallback;
  face::OutputFrame frame = face::neutral_frame(frame_time(0));
  fallback.apply(frame, 2);
  frame = measured(1, 0.5f);
  fallback.apply(frame, 0);
  EXPECT_EQ(frame.provenance[0], Provenance::neutral);
}

TEST(Fallback, ComesBackWithoutAJump) {
  for (const int lost_frames : {1, 5, 30, 200}) {
    Fallback fallback;
    face::OutputFrame before;
    for (int i = 0; i < 20; ++i) {
      before = measured(i, 0.0f);
      fallback.apply(before, 3);
    }
    for (int i = 20; i < 20 + lost_frames; ++i) {
      before = measured(i);
      fallback.apply(before, 0);
    }
    for (int i = 0; i < 100; ++i) {
      face::OutputFrame out = measured(20 + lost_frames + i, 1.0f);
      out.head = exp_rotation({0, 1.5, 0});
      fallback.apply(out, 3);
      ASSERT_LE(largest_step(out, before), 0.1) << i;
      ASSERT_LE(angle_between(out.head, before.head), 0.15) << i;
      ASSERT_GE(out.weights[0], before.weights[0]);
      if (i == 18) {
        EXPECT_NEAR(out.weights[0], 0.96, 0.01) << "a frame after 0.3 s";
        EXPECT_EQ(out.provenance[0], Provenance::measured);
      }
      if (i == 0) {
        EXPECT_NE(out.provenance[0], Provenance::measured);
        EXPECT_LT(out.confidence[0], 0.1f);
      }
      before = out;
    }
    EXPECT_EQ(before.weights[0], 1.0f);
    EXPECT_EQ(before.confidence[0], 0.9f);
    EXPECT_LT(angle_between(before.head, exp_rotation({0, 1.5, 0})), 1e-12);
  }
}

TEST(Fallback, ARegionsConfidenceFadesAndComesBackAsAShapesDoes) {
  Fallback fallback;
  bool faded = false;
  for (int i = 0; i < 200; ++i) {
    face::OutputFrame out = measured(i, 0.5F);
    out.region_confidence.fill(0.9F);
    fallback.apply(out, i >= 20 && i < 100 ? 0 : 3);
    for (const float confidence : out.region_confidence) ASSERT_EQ(confidence, out.confidence[0]) << i;
    faded = faded || (out.confidence[0] > 0.1F && out.confidence[0] < 0.8F);
  }
  EXPECT_TRUE(faded);
}

TEST(Fallback, TheFacesOwnMovementShowsAtOnceWhileItComesBack) {
  Fallback fallback;
  face::OutputFrame frame = measured(0, 0.0f);
  fallback.apply(frame, 1);
  frame = measured(1);
  fallback.apply(frame, 0);
  frame = measured(2, 0.5f);
  fallback.apply(frame, 1);
  const float first = frame.weights[0];
  frame = measured(3, 0.7f);
  fallback.apply(frame, 1);
  EXPECT_GT(frame.weights[0] - first, 0.2f);
}

TEST(Fallback, OneSensorsReturnIsEasedOver) {
  Fallback fallback;
  face::OutputFrame before = measured(0, 0.2f);
  fallback.apply(before, 12);
  double largest = 0;
  for (int i = 1; i < 120; ++i) {
    // The tracker's face jumps as a sensor is lost, and again as it returns.
    const bool lost = i >= 30 && i < 60;
    face::OutputFrame out = measured(i, lost ? 0.6f : 0.2f);
    fallback.apply(out, lost ? 11 : 12);
    largest = std::max(largest, largest_step(out, before));
    ASSERT_EQ(out.provenance[0], Provenance::measured);
    ASSERT_EQ(out.confidence[0], 0.9f);
    before = out;
  }
  EXPECT_LE(largest, 0.1 * 0.4);
  EXPECT_EQ(before.weights[0], 0.2f);
}

TEST(Fallback, AFlappingSensorDoesNotFreezeTheFace) {
  Fallback fallback;
  double worst = 0;
  for (int i = 0; i < 600; ++i) {
    const auto truth = static_cast<float>(0.5 + 0.4 * std::sin(i / 60.0 * 3));
    face::OutputFrame out = measured(i, truth);
    fallback.apply(out, i % 2 == 0 ? 12 : 11);
    if (i > 60) worst = std::max(worst, std::abs(static_cast<double>(out.weights[0]) - truth));
  }
  EXPECT_LT(worst, 0.25);
}

TEST(Fallback, BringsItsTimesIntoRange) {
  Fallback fallback({.hold_s = -1, .neutral_s = std::nan(""), .return_s = 0});
  face::OutputFrame frame = measured(0, 1.0f);
  fallback.apply(frame, 1);
  for (int i = 1; i < 30; ++i) {
    frame = measured(i, 1.0f);
    fallback.apply(frame, i < 10 ? 0 : 1);
    ASSERT_TRUE(std::isfinite(frame.weights[0]));
  }
  EXPECT_EQ(frame.weights[0], 1.0f);
}

TEST(Fallback, ForgetsWhenReset) {
  Fallback fallback;
  face::OutputFrame frame = measured(0, 1.0f);
  fallback.apply(frame, 1);
  fallback.reset();
  frame = measured(1, 0.3f);
  fallback.apply(frame, 0);
  EXPECT_EQ(frame.weights[0], 0.0f);
}

}  // namespace
}  // namespace mien::shaping::fallback_test
