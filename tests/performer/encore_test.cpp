// A performance that goes on without a seam.
#include "mien/performer/encore.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/performer/talking.h"

namespace mien::performer::encore_test {
namespace {

/// Two seconds that end amid a word and a turn of the head, walking half a metre a second.
PrologueMotion walking() {
  face::Motion motion = test::talking(121);
  for (face::MotionFrame& frame : motion.frames) frame.head_position_m = Vec3(0, 0, 0.5 * frame.time_s);
  return with_prologue(motion, PrologueKind::brief, Random(3));
}

TEST(Encore, RepeatsTheMotionAndNotThePrologue) {
  PrologueMotion motion = walking();
  const Encore encore = add_encore(motion);
  const face::MotionCurve curve(motion.motion);
  EXPECT_EQ(encore.begin_s, motion.times.motion_start_s);
  EXPECT_NEAR(encore.end_s, curve.duration_s(), 1e-9);
  EXPECT_NEAR(encore.end_s - encore.begin_s, 3, 1e-6);
  for (const double t : {0.0, 5.0, 12.7, 14.9}) {
    EXPECT_EQ(encore.at(curve, t).weights, curve.at(t).weights);
    EXPECT_EQ(encore.at(curve, t).head.coeffs(), curve.at(t).head.coeffs());
  }
  const double round_s = encore.end_s - encore.begin_s;
  for (const double t : {0.1, 0.9, 1.7, 2.6})
    for (const double rounds : {1.0, 2.0, 1000.0}) {
      const face::MotionFrame first = curve.at(encore.begin_s + t);
      const face::MotionFrame later = encore.at(curve, encore.begin_s + t + rounds * round_s);
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        EXPECT_NEAR(later.weights[k], first.weights[k], 1e-5);
      EXPECT_LT(angle_between(later.head, first.head), 1e-6);
      EXPECT_NEAR((later.head_position_m - first.head_position_m - rounds * encore.walked_m).norm(), 0, 1e-6);
    }
}

TEST(Encore, HasNoSeam) {
  PrologueMotion motion = walking();
  const Encore encore = add_encore(motion);
  const face::MotionCurve curve(motion.motion);
  // Walked for two seconds and came to a halt: two times half a metre, and less than another quarter.
  EXPECT_GT(encore.walked_m.z(), 1);
  EXPECT_LT(encore.walked_m.z(), 1.3);
  constexpr double kStepS = 1e-3;
  face::MotionFrame before = encore.at(curve, encore.begin_s);
  for (double t = encore.begin_s + kStepS; t < encore.begin_s + 10; t += kStepS) {
    const face::MotionFrame now = encore.at(curve, t);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      ASSERT_LT(std::abs(now.weights[k] - before.weights[k]), 0.01) << t;
    ASSERT_LT(angle_between(now.head, before.head), 0.005) << t;
    ASSERT_LT((now.head_position_m - before.head_position_m).norm(), 0.001) << t;
    before = now;
  }
}

TEST(Encore, RepeatedInMemoryIsWhatIsPlayed) {
  PrologueMotion motion = walking();
  const Encore encore = add_encore(motion);
  const face::MotionCurve curve(motion.motion);
  const double end_s = encore.begin_s + 8;  // Two rounds and two thirds.
  PrologueMotion repeated = motion;
  repeat(repeated, encore, end_s);
  EXPECT_NEAR(repeated.motion.duration_s(), end_s, 1.0 / 60);
  EXPECT_LE(repeated.motion.duration_s(), end_s);
  double before_s = -1;
  for (const face::MotionFrame& frame : repeated.motion.frames) {
    ASSERT_GT(frame.time_s, before_s);
    before_s = frame.time_s;
    const face::MotionFrame played = encore.at(curve, frame.time_s);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      ASSERT_NEAR(frame.weights[k], played.weights[k], 1e-5) << frame.time_s;
    ASSERT_LT((frame.head_position_m - played.head_position_m).norm(), 1e-6) << frame.time_s;
  }
}

TEST(Encore, OfAMotionThatIsLongEnoughCutsIt) {
  PrologueMotion motion = walking();
  const Encore encore = add_encore(motion);
  repeat(motion, encore, encore.begin_s + 1);
  EXPECT_LE(motion.motion.duration_s(), encore.begin_s + 1);
}

}  // namespace
}  // namespace mien::performer::encore_test
