#include "mien/shaping/ease_out.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/shaping/frames.h"

namespace mien::shaping::ease_out_test {
namespace {

constexpr double kStep_s = 1.0 / 60;
constexpr double kReturn_s = 0.3;

TEST(EaseOut, EachPartIsIndependentAndLeavesTheOthersBits) {
  for (std::size_t part = 0; part < kPartCount; ++part) {
    EaseOut ease_out;
    face::OutputFrame shown = measured(0, 0.2F);
    shown.head_position_known = true;
    const auto next = [](int i) {
      face::OutputFrame frame = measured(i, 0.7F);
      frame.tongue_out = 0.4F;
      frame.head = exp_rotation({0.1, 0.5, 0});
      frame.eyes_rad = {Eigen::Vector2f(0.2F, 0.1F), Eigen::Vector2f(-0.1F, 0.3F)};
      frame.head_position_m = {0.2F, -0.4F, 0};
      frame.head_position_known = true;
      return frame;
    };
    ease_out.begin(part, shown, next(1));
    ASSERT_TRUE(ease_out.active());
    for (int i = 1; i <= 60; ++i) {
      face::OutputFrame out = next(i);
      ease_out.apply(out, kStep_s, kReturn_s);
      const face::OutputFrame plain = next(i);
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        if (k != part) {
          ASSERT_EQ(out.weights[k], plain.weights[k]);
        }
      if (part != kTonguePart) {
        ASSERT_EQ(out.tongue_out, plain.tongue_out);
      }
      if (part != kHeadPart) {
        ASSERT_EQ(angle_between(out.head, plain.head), 0);
      }
      if (part != kEyesPart) {
        ASSERT_EQ(out.eyes_rad, plain.eyes_rad);
      }
      if (part != kPositionPart) {
        ASSERT_EQ(out.head_position_m, plain.head_position_m);
      }
      // At 0.3 s 5 % are left: of the weight 0.5, of the tongue 0.4, of the head, of each eye and of the
      // place.
      if (i != 18) continue;
      if (part < face::kShapeCount) {
        EXPECT_NEAR(out.weights[part], 0.7 - 0.05 * 0.5, 1e-3);
      }
      if (part == kTonguePart) {
        EXPECT_NEAR(out.tongue_out, 0.4 - 0.05 * 0.4, 1e-3);
      }
      if (part == kHeadPart) {
        EXPECT_NEAR(angle_between(out.head, plain.head), 0.05 * std::hypot(0.1, 0.5), 1e-3);
      }
      if (part == kEyesPart) {
        EXPECT_NEAR(out.eyes_rad[0].x(), 0.95 * 0.2, 1e-3);
        EXPECT_NEAR(out.eyes_rad[1].y(), 0.95 * 0.3, 1e-3);
      }
      if (part == kPositionPart) {
        EXPECT_NEAR(out.head_position_m.y(), 0.95 * -0.4, 1e-3);
      }
    }
    EXPECT_FALSE(ease_out.active()) << "done after 3 return_s";
  }
}

TEST(EaseOut, FollowsItsClosedForm) {
  EaseOut ease_out;
  ease_out.begin(0, measured(0, 1), measured(0, 0));
  double before = 1;
  for (int i = 1; i <= 53; ++i) {
    face::OutputFrame out = measured(i, 0);
    ease_out.apply(out, to_seconds(frame_time(i) - frame_time(i - 1)), kReturn_s);
    const double t = to_seconds(frame_time(i) - frame_time(0));
    ASSERT_NEAR(out.weights[0], offset_left(kConstantsTo5Percent / kReturn_s * t), 1e-6);
    ASSERT_LE(before - out.weights[0], 0.0975);
    before = out.weights[0];
  }
}

TEST(EaseOut, ABeginInTheMiddleKeepsTheSpeed) {
  EaseOut ease_out;
  ease_out.begin(0, measured(0, 1), measured(0, 0));
  face::OutputFrame out;
  for (int i = 1; i <= 5; ++i) {
    out = measured(i, 0);
    ease_out.apply(out, kStep_s, kReturn_s);
  }
  // The same difference to the same source, begun again: nothing changes but the time at which it is done.
  EaseOut again = ease_out;
  again.begin(0, out, measured(6, 0));
  face::OutputFrame one = measured(6, 0), other = measured(6, 0);
  ease_out.apply(one, kStep_s, kReturn_s);
  again.apply(other, kStep_s, kReturn_s);
  EXPECT_NEAR(one.weights[0], other.weights[0], 1e-6);
  again.stop();
  EXPECT_FALSE(again.active());
}

TEST(EaseOut, FromOneMovingFaceToAnotherNothingJumps) {
  // Two faces that move at different speeds; shown is the first until frame 10, then the second, eased.
  const auto moving = [](int i, double speed) { return measured(i, static_cast<float>(0.3 + speed * i)); };
  EaseOut at_rest, ease_out;
  double largest = 0, largest_at_rest = 0;
  std::array<double, 4> path{}, path_at_rest{};
  for (int i = 0; i < 40; ++i) {
    face::OutputFrame out = moving(i, i < 10 ? 0.02 : -0.005), plain = out;
    if (i == 10) {
      const face::OutputFrame shown = moving(9, 0.02), shown_before = moving(8, 0.02);
      const face::OutputFrame next = moving(9, -0.005), next_before = moving(8, -0.005);
      ease_out.begin_moving(0, {shown_before, shown}, {next_before, next}, kStep_s);
      at_rest.begin(0, shown, out);
    }
    ease_out.apply(out, kStep_s, kReturn_s);
    at_rest.apply(plain, kStep_s, kReturn_s);
    const auto third = [i](std::array<double, 4>& values, float newest) {
      std::ranges::rotate(values, values.begin() + 1);
      values.back() = newest;
      return i < 3 ? 0 : std::abs(values[3] - 3 * values[2] + 3 * values[1] - values[0]);
    };
    largest = std::max(largest, third(path, out.weights[0]));
    largest_at_rest = std::max(largest_at_rest, third(path_at_rest, plain.weights[0]));
  }
  EXPECT_LT(largest, 0.012);
  EXPECT_LT(largest, largest_at_rest / 2);
  EXPECT_NEAR(path.back(), 0.3 - 0.005 * 39, 0.005) << "it has arrived";
}

TEST(EaseOut, APositionThatOneDoesNotKnowIsNotEased) {
  EaseOut ease_out;
  ease_out.begin(kPositionPart, standing_at(0, {1, 0, 0}), measured(1));
  EXPECT_FALSE(ease_out.active());
  ease_out.begin(kPositionPart, measured(0), standing_at(1, {1, 0, 0}));
  EXPECT_FALSE(ease_out.active());
  // Nor is one that stops being told.
  ease_out.begin(kPositionPart, standing_at(0, {1, 0, 0}), standing_at(1, {0, 0, 0}));
  EXPECT_TRUE(ease_out.active());
  face::OutputFrame out = measured(1);
  ease_out.apply(out, kStep_s, kReturn_s);
  EXPECT_TRUE(same_bits(out, measured(1)));
  EXPECT_FALSE(ease_out.active());
}

}  // namespace
}  // namespace mien::shaping::ease_out_test
