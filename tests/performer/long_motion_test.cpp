// A performance that is drawn piece by piece, or repeated.
#include "mien/performer/long_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/performer/talking.h"

namespace mien::performer::long_motion_test {
namespace {

constexpr double kShortS = 3;

/// Three seconds that end amid a word; every piece begins elsewhere in the world.
face::Motion piece(std::size_t index) {
  face::Motion motion = test::talking(180);
  for (face::MotionFrame& frame : motion.frames) {
    frame.head_position_m = Vec3(0.1 * static_cast<double>(index), 0, 0.05 * frame.time_s);
    frame.tongue_out = index == 1 ? 0.5F : 0.0F;
  }
  return motion;
}

PrologueMotion first_piece() {
  return with_prologue(piece(0), PrologueKind::brief, Random(3));
}

/// Three pieces.
LongMotion three_pieces() {
  const PrologueMotion first = first_piece();
  const double last_s = first.times.motion_start_s + 2 * kShortS + piece(2).duration_s();
  return {first,
          {.draw = [](std::size_t index) { return index < 3 ? piece(index) : face::Motion(); },
           .duration_s = last_s,
           .piece_s = kShortS}};
}

void expect_no_seam(LongMotion& motion, double from_s, double to_s) {
  constexpr double kStepS = 1e-3;
  face::MotionFrame before = motion.at(from_s);
  for (double t = from_s + kStepS; t < to_s; t += kStepS) {
    const face::MotionFrame now = motion.at(t);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      ASSERT_LT(std::abs(now.weights[k] - before.weights[k]), 0.01) << t;
    ASSERT_LT(std::abs(now.tongue_out - before.tongue_out), 0.01) << t;
    ASSERT_LT(angle_between(now.head, before.head), 0.005) << t;
    ASSERT_LT((now.head_position_m - before.head_position_m).norm(), 0.001) << t;
    before = now;
  }
}

TEST(LongMotion, OfOnePieceIsItsCurve) {
  const PrologueMotion first = first_piece();
  const face::MotionCurve curve(first.motion);
  LongMotion motion(first);
  EXPECT_EQ(motion.duration_s(), curve.duration_s());
  EXPECT_EQ(motion.prologue().motion_start_s, first.times.motion_start_s);
  for (const double t : {-0.2, 0.0, 5.0, 12.7, 14.9, 20.0}) {
    EXPECT_EQ(motion.at(t).weights, curve.at(t).weights);
    EXPECT_EQ(motion.at(t).head.coeffs(), curve.at(t).head.coeffs());
  }
}

TEST(LongMotion, PiecesJoinWithoutASeam) {
  LongMotion motion = three_pieces();
  expect_no_seam(motion, motion.prologue().motion_start_s, motion.duration_s() + 1);
}

TEST(LongMotion, JoinedInMemoryIsWhatIsPlayed) {
  LongMotion played = three_pieces();
  const PrologueMotion joined = join(
      first_piece(), {.draw = [](std::size_t index) { return index < 3 ? piece(index) : face::Motion(); },
                      .piece_s = kShortS});
  EXPECT_EQ(joined.motion.duration_s(), played.duration_s());
  double before_s = -1;
  for (const face::MotionFrame& frame : joined.motion.frames) {
    ASSERT_GT(frame.time_s, before_s);
    before_s = frame.time_s;
    ASSERT_EQ(played.at(frame.time_s).weights, frame.weights) << frame.time_s;
  }
}

TEST(PieceScripts, OfTenMinutesIsTheScript) {
  for (const double seconds : {1.0, 60.0, kPieceS}) {
    const std::vector<Script> scripts = piece_scripts(Block::mixed, seconds);
    ASSERT_EQ(scripts.size(), 1U);
    EXPECT_EQ(scripts.front().segments.size(), default_script(Block::mixed, seconds).segments.size());
    EXPECT_EQ(scripts.front().duration_s(), default_script(Block::mixed, seconds).duration_s());
  }
}

TEST(PieceScripts, OfThreeHoursAreEighteenOfTenMinutes) {
  const std::vector<Script> scripts = piece_scripts(Block::mixed, 10'800);
  ASSERT_EQ(scripts.size(), 18U);
  for (const Script& script : scripts) EXPECT_NEAR(script.duration_s(), kPieceS, 1e-6);
  EXPECT_EQ(piece_scripts(Block::free, 601).size(), 2U);
  EXPECT_NEAR(piece_scripts(Block::free, 601).back().duration_s(), 1, 1e-9);
}

TEST(LongMotion, EachPieceIsPlayedAfterItsFirstSecond) {
  LongMotion motion = three_pieces();
  for (std::size_t index = 1; index < 3; ++index) {
    const face::MotionCurve curve(piece(index));
    const double begin_s = motion.prologue().motion_start_s + kShortS * static_cast<double>(index);
    for (const double t : {1.1, 1.9, 2.9})
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        EXPECT_NEAR(motion.at(begin_s + t).weights[k], curve.at(t).weights[k], 1e-5);
  }
}

TEST(LongMotion, TimesMayStepBackByLessThanAPiece) {
  LongMotion ahead = three_pieces(), in_order = three_pieces();
  const double start_s = ahead.prologue().motion_start_s;
  for (double t = start_s; t < start_s + 3 * kShortS - 2; t += 0.1) {
    static_cast<void>(ahead.at(t + 2));
    EXPECT_EQ(ahead.at(t).weights, in_order.at(t).weights) << t;
  }
}

TEST(LongMotion, HoldsItsLastFrameAfterItsEnd) {
  LongMotion motion = three_pieces();
  const face::BlendshapeWeights last = motion.at(motion.duration_s()).weights;
  EXPECT_EQ(motion.at(motion.duration_s() + 100).weights, last);
  EXPECT_EQ(piece(2).frames.back().weights, last);
}

TEST(LongMotion, OfARepeatedMotionIsItsEncoreUntilItEnds) {
  PrologueMotion repeated = first_piece();
  const Encore encore = add_encore(repeated);
  const face::MotionCurve curve(repeated.motion);
  const double end_s = repeated.times.motion_start_s + 20;
  LongMotion motion(repeated, encore, end_s);
  EXPECT_EQ(motion.duration_s(), end_s);
  for (double t = 0; t < end_s; t += 0.7) EXPECT_EQ(motion.at(t).weights, encore.at(curve, t).weights);
  EXPECT_EQ(motion.at(end_s + 5).weights, encore.at(curve, end_s).weights);
  expect_no_seam(motion, repeated.times.motion_start_s, end_s + 1);
}

TEST(LongMotion, AnExpressionIsHeldInEveryPiece) {
  const PrologueMotion first = first_piece();
  const std::size_t smile = face::shape("mouthSmile_L");
  LongMotion motion(first, {.draw = piece, .duration_s = 100, .piece_s = kShortS},
                    {{.shapes = {smile}, .value = 0.9F, .begin_s = 2, .end_s = 7}});
  const double start_s = first.times.motion_start_s;
  EXPECT_LT(motion.at(start_s + 1.9).weights[smile], 0.9F);
  for (double t = 2.5; t < 7; t += 0.1) EXPECT_GE(motion.at(start_s + t).weights[smile], 0.9F);
  EXPECT_LT(motion.at(start_s + 7.6).weights[smile], 0.9F);
}

}  // namespace
}  // namespace mien::performer::long_motion_test
