#include "mien/performer/prologue.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/time.h"
#include "mien/core/units.h"
#include "mien/face/face.h"
#include "mien/face/gaze_targets.h"
#include "mien/performer/performer.h"
#include "tests/performer/talking.h"

namespace mien::performer::prologue_test {
namespace {

using face::kShapeCount;

face::Motion some_motion() {
  return perform(default_script(Block::free, 10), plain_style(), Random(9));
}

/// Pitch (nod down) and yaw (to the left) of the forward axis.
double pitch_of(const Quat& head) {
  return std::asin(std::clamp(-(head * Vec3::UnitZ()).y(), -1.0, 1.0));
}
double yaw_of(const Quat& head) {
  return std::atan2((head * Vec3::UnitZ()).x(), (head * Vec3::UnitZ()).z());
}

TEST(Prologue, NoneChangesNothing) {
  const auto motion = some_motion();
  const auto with = with_prologue(motion, PrologueKind::none, Random(1));
  EXPECT_EQ(with.motion.frames.size(), motion.frames.size());
  EXPECT_EQ(with.times.motion_start_s, 0);
}

TEST(Prologue, PhasesFollowEachOtherAndTheMotionFollowsThem) {
  const auto motion = some_motion();
  for (const PrologueKind kind :
       {PrologueKind::brief, PrologueKind::full, PrologueKind::guided, PrologueKind::gaze}) {
    const auto [with, times] = with_prologue(motion, kind, Random(1));
    EXPECT_EQ(times.neutral.begin_s, 0);
    EXPECT_DOUBLE_EQ(times.neutral.end_s,
                     kind == PrologueKind::guided || kind == PrologueKind::gaze ? 4.6 : 3);
    EXPECT_EQ(times.nod.begin_s, times.neutral.end_s);
    EXPECT_EQ(times.shake.begin_s, times.nod.end_s);
    EXPECT_EQ(times.anchors.begin_s, times.shake.end_s);
    EXPECT_EQ(times.range_of_motion.begin_s, times.anchors.end_s);
    EXPECT_EQ(times.gaze.begin_s, times.range_of_motion.end_s);
    EXPECT_EQ(times.ease.begin_s, times.gaze.end_s);
    EXPECT_NEAR(times.gaze.end_s - times.gaze.begin_s, kind == PrologueKind::gaze ? 13.5 : 0, 1e-9);
    EXPECT_NEAR(times.ease.end_s - times.ease.begin_s, 0.5, 1e-9);
    EXPECT_EQ(times.motion_start_s, times.ease.end_s);
    double before = -1;
    for (const auto& frame : with.frames) {
      EXPECT_GT(frame.time_s, before);
      before = frame.time_s;
    }
    const auto start = with.frames.size() - motion.frames.size();
    EXPECT_NEAR(with.frames[start].time_s, times.motion_start_s, 1e-9);
    for (std::size_t i = 0; i < motion.frames.size(); ++i) {
      EXPECT_EQ(with.frames[start + i].weights, motion.frames[i].weights);
      EXPECT_NEAR(with.frames[start + i].time_s, motion.frames[i].time_s + times.motion_start_s, 1e-9);
    }
  }
}

TEST(Prologue, NeutralNodAndShakeHaveNoWeights) {
  const auto [with, times] = with_prologue(some_motion(), PrologueKind::full, Random(2));
  for (const auto& frame : with.frames) {
    if (frame.time_s >= times.shake.end_s) break;
    EXPECT_EQ(frame.weights, face::BlendshapeWeights{});
    if (frame.time_s < times.neutral.end_s) {
      EXPECT_LT(angle_between(frame.head, Quat::Identity()), 1.5 * kRadPerDeg);
    }
  }
}

TEST(Prologue, NodBeginsDownwardsAndBothTakeTwoCycles) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto [with, times] = with_prologue(some_motion(), PrologueKind::brief, Random(seed));
    double down = 0;
    double up = 0;
    double left = 0;
    double right = 0;
    int nod_peaks = 0;
    int shake_peaks = 0;
    double first_large = 0;
    for (std::size_t i = 1; i < with.frames.size(); ++i) {
      const auto& frame = with.frames[i];
      const double pitch = pitch_of(frame.head);
      const double yaw = yaw_of(frame.head);
      if (frame.time_s >= times.nod.begin_s && frame.time_s < times.nod.end_s) {
        down = std::max(down, pitch);
        up = std::min(up, pitch);
        if (first_large == 0 && std::abs(pitch) > 5 * kRadPerDeg) first_large = pitch;
        if (pitch > 10 * kRadPerDeg && pitch_of(with.frames[i - 1].head) <= 10 * kRadPerDeg) ++nod_peaks;
        EXPECT_LT(std::abs(yaw), 6 * kRadPerDeg);
      }
      if (frame.time_s >= times.shake.begin_s && frame.time_s < times.shake.end_s) {
        left = std::max(left, yaw);
        right = std::min(right, yaw);
        if (yaw > 10 * kRadPerDeg && yaw_of(with.frames[i - 1].head) <= 10 * kRadPerDeg) ++shake_peaks;
        EXPECT_LT(std::abs(pitch), 6 * kRadPerDeg);
      }
    }
    EXPECT_GT(first_large, 0);
    EXPECT_EQ(nod_peaks, 2);
    EXPECT_EQ(shake_peaks, 2);
    for (const double peak : {down, -up, left, -right}) EXPECT_NEAR(peak, 20 * kRadPerDeg, 4 * kRadPerDeg);
  }
}

TEST(Prologue, EaseReachesTheFirstFrame) {
  const auto motion = some_motion();
  const auto [with, times] = with_prologue(motion, PrologueKind::brief, Random(3));
  const auto start = with.frames.size() - motion.frames.size();
  for (std::size_t k = 0; k < kShapeCount; ++k)
    EXPECT_NEAR(with.frames[start - 1].weights[k], motion.frames[0].weights[k], 0.02);
  EXPECT_LT(angle_between(with.frames[start - 1].head, with.frames[start].head), 0.5 * kRadPerDeg);
}

TEST(Prologue, EaseSkipsFramesWithoutFace) {
  auto motion = some_motion();
  motion.frames[0].has_face = false;
  motion.frames[0].weights.values.fill(77);
  const auto [with, times] = with_prologue(motion, PrologueKind::brief, Random(3));
  for (const auto& frame : with.frames) {
    if (frame.time_s < times.motion_start_s) {
      EXPECT_LT(frame.weights[0], 2.0F);
    }
  }
}

TEST(Prologue, LabLeavesOutNodAndShake) {
  const auto [with, times] =
      with_prologue(some_motion(), PrologueKind::brief, Random(4), {.gestures = false});
  EXPECT_EQ(times.nod.begin_s, times.nod.end_s);
  EXPECT_EQ(times.shake.begin_s, times.shake.end_s);
  EXPECT_NEAR(times.motion_start_s, 3.5, 1e-9);
  EXPECT_EQ(with.frames[100].head.coeffs(), Quat::Identity().coeffs());
}

TEST(Prologue, GazeLooksAtFiveTargetsAndComesBack) {
  const auto [with, times] = with_prologue(some_motion(), PrologueKind::gaze, Random(4), {.gestures = false});
  const auto targets = face::gaze_targets();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    // Towards its end: they turned late, and may blink.
    const double end_s = times.gaze.begin_s + kGazeTarget_s * static_cast<double>(i + 1);
    const auto eyes = face::eyes_rad(with.frames[static_cast<std::size_t>(end_s * kFrameRateHz) - 2].weights);
    EXPECT_LT((eyes[0] - targets[i].direction_rad).norm(), 0.05F) << targets[i].name;
    EXPECT_LT((eyes[0] - eyes[1]).norm(), 1e-5F);
  }
  EXPECT_TRUE(times.prompts.empty()) << "nothing is told of shapes";
  float most = 0;
  for (std::size_t i = 1; i < with.frames.size(); ++i)
    if (with.frames[i].time_s > times.ease.begin_s && with.frames[i].time_s <= times.motion_start_s)
      most = std::max(
          most,
          (face::eyes_rad(with.frames[i].weights)[0] - face::eyes_rad(with.frames[i - 1].weights)[0]).norm());
  EXPECT_LT(most, 0.02F) << "without a jump into the motion";
}

TEST(Prologue, FullPromptsAMinuteAndEveryOneIsMissed) {
  const auto [with, times] = with_prologue(some_motion(), PrologueKind::full, Random(5));
  EXPECT_GE(times.range_of_motion.end_s - times.range_of_motion.begin_s, 60);
  std::size_t anchors = 0;
  for (const Prompt& prompt : times.prompts) {
    anchors += prompt.anchor ? 1 : 0;
    // What the face did in the middle of its answer, against what was asked.
    const double middle_s = 0.5 * (prompt.begin_s + prompt.end_s) + 0.35;
    const auto& frame = with.frames[static_cast<std::size_t>(middle_s * kFrameRateHz)];
    double missed = 0;
    double done = 0;
    double asked = 0;
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      missed = std::max<double>(missed, std::abs(frame.weights[k] - prompt.target[k]));
      if (prompt.target[k] > 0) {
        done += frame.weights[k];
        asked += prompt.target[k];
      }
    }
    EXPECT_GT(missed, 0.02) << prompt.name;
    EXPECT_GT(done, 0.3 * asked) << prompt.name;
    // Late: nothing asked for moves in the first 0.15 s, blinks aside.
    const auto& early = with.frames[static_cast<std::size_t>((prompt.begin_s + 0.14) * kFrameRateHz)];
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      if (prompt.target[k] > 0 && !face::kShapeNames[k].starts_with("eyeBlink")) {
        EXPECT_LT(early.weights[k], 0.35F) << prompt.name << " " << face::kShapeNames[k];
      }
    }
  }
  EXPECT_GE(anchors, 8U);
  EXPECT_GE(times.prompts.size() - anchors, 25U);
}

TEST(Prologue, FullDiffersFromPersonToPerson) {
  const auto a = with_prologue(some_motion(), PrologueKind::full, Random(5));
  const auto b = with_prologue(some_motion(), PrologueKind::full, Random(6));
  const auto c = with_prologue(some_motion(), PrologueKind::full, Random(5));
  const auto i = static_cast<std::size_t>((a.times.prompts[5].begin_s + 1.2) * kFrameRateHz);
  EXPECT_NE(a.motion.frames[i].weights, b.motion.frames[i].weights);
  EXPECT_EQ(a.motion.frames[i].weights, c.motion.frames[i].weights);
}

TEST(Prologue, EmptyMotionIsOnlyPrologue) {
  const auto with = with_prologue(face::Motion{}, PrologueKind::brief, Random(1));
  EXPECT_EQ(with.motion.frames.size(), 12.5 * 60);
}

TEST(Prologue, AHeadThatGoesOnWithoutAFaceStaysSo) {
  face::Motion motion = test::talking(30);
  EXPECT_FALSE(with_prologue(motion, PrologueKind::brief, Random(1)).motion.head_without_face);
  motion.head_without_face = true;
  EXPECT_TRUE(with_prologue(motion, PrologueKind::brief, Random(1)).motion.head_without_face);
}

}  // namespace
}  // namespace mien::performer::prologue_test
