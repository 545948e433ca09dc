#include "mien/shaping/smoothing.h"

#include <gtest/gtest.h>

#include "tests/shaping/frames.h"

namespace mien::shaping::smoothing_test {
namespace {

TEST(SmoothingFor, GoesFromNothingToADelayThatItNames) {
  EXPECT_EQ(smoothing_for(0, true), SmoothingSettings{});
  EXPECT_EQ(smoothing_for(-1, true), SmoothingSettings{});
  EXPECT_EQ(smoothing_for(std::nan(""), true), SmoothingSettings{});
  EXPECT_NEAR(smoothing_for(1e-9, false).weights->min_cutoff_hz, 15, 1e-6);
  EXPECT_NEAR(smoothing_for(0.5, false).weights->min_cutoff_hz, 3.873, 1e-3);
  EXPECT_NEAR(smoothing_for(1, false).weights->min_cutoff_hz, 1, 1e-9);
  EXPECT_NEAR(smoothing_for(9, false).weights->min_cutoff_hz, 1, 1e-9);
  EXPECT_FALSE(smoothing_for(1, false).head);
  EXPECT_TRUE(smoothing_for(1, true).head);
}

TEST(Smoothing, IsOffByDefaultAndChangesNoBit) {
  Smoothing smoothing;
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const face::OutputFrame in = moving(i, random);
    face::OutputFrame out = in;
    smoothing.apply(out);
    ASSERT_TRUE(same_bits(in, out));
  }
}

TEST(Smoothing, IsOneEuroAShape) {
  Smoothing smoothing;
  smoothing.set(smoothing_for(0.7, false));
  OneEuro filter(*smoothing_for(0.7, false).weights);
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    face::OutputFrame frame = moving(i, random);
    const double expected = filter.filter(frame.time, frame.weights[9]);
    const Quat head = frame.head;
    smoothing.apply(frame);
    ASSERT_EQ(frame.weights[9], static_cast<float>(expected));
    ASSERT_EQ(frame.head.coeffs(), head.coeffs());
  }
}

TEST(Smoothing, TakesTremorAndKeepsAQuickMovement) {
  for (const double amount : {0.3, 0.6, 1.0}) {
    Smoothing smoothing;
    smoothing.set(smoothing_for(amount, true));
    Random random(3);
    double in_power = 0;
    double out_power = 0;
    face::OutputFrame frame;
    for (int i = 0; i < 600; ++i) {
      frame = measured(i, 0.3f);
      frame.weights[5] += static_cast<float>(random.normal(0, 0.02));
      const double in = frame.weights[5] - 0.3;
      smoothing.apply(frame);
      if (i < 60) continue;
      in_power += in * in;
      out_power += (frame.weights[5] - 0.3) * (frame.weights[5] - 0.3);
    }
    EXPECT_LT(out_power, (amount > 0.5 ? 0.3 : 0.6) * in_power) << amount;
    // A smile in a fifth of a second: three quarters of it are there after another fifth.
    for (int i = 0; i < 24; ++i) {
      frame = measured(600 + i, std::min(1.0f, 0.3f + 0.7f * static_cast<float>(i) / 12));
      smoothing.apply(frame);
    }
    EXPECT_GT(frame.weights[5], 0.3 + 0.75 * 0.7) << amount;
  }
}

TEST(Smoothing, BeginsWithoutAJumpWhenSwitchedOn) {
  Smoothing smoothing;
  face::OutputFrame frame = measured(0, 0.1f);
  smoothing.apply(frame);
  smoothing.set(smoothing_for(1, true));
  frame = measured(1, 0.8f);
  smoothing.apply(frame);
  EXPECT_EQ(frame.weights[0], 0.8f);
  smoothing.reset();
  frame = measured(2, 0.2f);
  smoothing.apply(frame);
  EXPECT_EQ(frame.weights[0], 0.2f);
}

TEST(Smoothing, SmoothsTheHeadWhenAsked) {
  Smoothing smoothing;
  smoothing.set(smoothing_for(0.8, true));
  Random random(4);
  double in = 0;
  double out = 0;
  for (int i = 0; i < 300; ++i) {
    face::OutputFrame frame = measured(i);
    const Vec3 noise(random.normal(0, 0.01), random.normal(0, 0.01), random.normal(0, 0.01));
    frame.head = exp_rotation(noise);
    smoothing.apply(frame);
    if (i < 60) continue;
    in += noise.squaredNorm();
    out += log_rotation(frame.head).squaredNorm();
  }
  EXPECT_LT(out, 0.3 * in);
}

TEST(Smoothing, AKnownPositionIsOneEuroACoordinate) {
  Smoothing smoothing;
  smoothing.set(smoothing_for(0.7, true));
  OneEuro filter(*smoothing_for(0.7, true).position);
  for (int i = 0; i < 100; ++i) {
    face::OutputFrame frame = standing_at(i, {0, static_cast<float>(0.1 * std::sin(0.3 * i)), 1});
    const double expected = filter.filter(frame.time, static_cast<double>(frame.head_position_m.y()));
    smoothing.apply(frame);
    ASSERT_EQ(frame.head_position_m.y(), static_cast<float>(expected));
    ASSERT_EQ(frame.head_position_m.x(), 0);
  }
  face::OutputFrame unknown = measured(100);
  smoothing.apply(unknown);
  EXPECT_FALSE(unknown.head_position_known);
  EXPECT_EQ(unknown.head_position_m, Vec3f(0, 0, 0));
  // What is known again passes as it is.
  face::OutputFrame back = standing_at(101, {3, 0, 0});
  smoothing.apply(back);
  EXPECT_EQ(back.head_position_m, Vec3f(3, 0, 0));
}

}  // namespace
}  // namespace mien::shaping::smoothing_test
