#include "mien/performer/head_motion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mien/core/time.h"
#include "mien/core/units.h"

namespace mien::performer::head_motion_test {
namespace {

HeadTrack play(HeadActivity activity, std::size_t frames, std::uint64_t seed) {
  const std::array episodes = {HeadEpisode{0, activity}};
  return draw_head_motion(frames, episodes, 1.0, {}, Random(seed));
}

double tilt_of(const Quat& head) {
  return angle_between(head, Quat::Identity());
}

TEST(HeadMotion, AxesAreThoseOfTheHeadFrame) {
  // Nod down: forward (+Z) goes down; to the left: forward goes to +X.
  EXPECT_LT((head_orientation({0.3, 0, 0}) * Vec3::UnitZ()).y(), -0.2);
  EXPECT_GT((head_orientation({0, 0.3, 0}) * Vec3::UnitZ()).x(), 0.2);
  EXPECT_GT((head_orientation({0, 0, 0.3}) * Vec3::UnitX()).y(), 0.2);
  EXPECT_EQ(neck_displacement_m(Quat::Identity()), Vec3::Zero());
  EXPECT_GT(neck_displacement_m(head_orientation({0.3, 0, 0})).z(), 0.02);  // A nod carries the head forward.
}

TEST(HeadMotion, StillHeadsSwayAndNoMore) {
  for (const Quat& head : play(HeadActivity::still, 3600, 1).orientation)
    EXPECT_LT(tilt_of(head), 2.5 * kRadPerDeg);
}

TEST(HeadMotion, NodsAndTurnsReachTwentyDegreesAndNotMuchMore) {
  for (const HeadActivity activity : {HeadActivity::nodding, HeadActivity::turning}) {
    double largest = 0;
    for (std::uint64_t seed = 0; seed < 5; ++seed)
      for (const Quat& head : play(activity, 3600, seed).orientation)
        largest = std::max(largest, tilt_of(head));
    EXPECT_GT(largest, 14 * kRadPerDeg);
    EXPECT_LT(largest, 26 * kRadPerDeg);
  }
}

TEST(HeadMotion, WalkingBouncesAtTheRateOfStepsAndGoesForward) {
  const HeadTrack track = play(HeadActivity::walking, 3600, 3);
  int crossings = 0;
  double highest = 0;
  for (std::size_t i = 300; i < 3300; ++i) {
    highest = std::max(highest, std::abs(track.position_m[i].y()));
    if (track.position_m[i - 1].y() < 0 && track.position_m[i].y() >= 0) ++crossings;
  }
  EXPECT_GT(crossings / 50.0, 1.6);
  EXPECT_LT(crossings / 50.0, 2.3);
  EXPECT_GT(highest, 0.012);
  EXPECT_LT(highest, 0.045);
  EXPECT_GT((track.position_m.back() - track.position_m.front()).norm(), 20);
}

TEST(HeadMotion, RunningShakesHarderThanWalking) {
  const auto rms_acceleration = [](HeadActivity activity) {
    const HeadTrack track = play(activity, 1800, 4);
    double sum = 0;
    for (std::size_t i = 121; i < 1600; ++i) {
      const double a = (track.position_m[i + 1] - 2 * track.position_m[i] + track.position_m[i - 1]).y() *
                       kFrameRateHz * kFrameRateHz;
      sum += a * a / 1479;
    }
    return std::sqrt(sum);
  };
  const double walking = rms_acceleration(HeadActivity::walking);
  const double running = rms_acceleration(HeadActivity::running);
  EXPECT_GT(walking, 1.0);
  EXPECT_LT(walking, 6.0);
  EXPECT_GT(running, 5.0);
  EXPECT_LT(running, 25.0);
}

TEST(HeadMotion, DartingIsFastAndStaysOnTheNeck) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const HeadTrack track = play(HeadActivity::darting, 1800, seed);
    double fastest = 0, largest = 0;
    for (std::size_t i = 1; i < track.orientation.size(); ++i) {
      fastest =
          std::max(fastest, angle_between(track.orientation[i - 1], track.orientation[i]) * kFrameRateHz);
      largest = std::max(largest, tilt_of(track.orientation[i]));
      EXPECT_LT(track.position_m[i].norm(), 0.2);
    }
    EXPECT_GT(fastest, 250 * kRadPerDeg);
    EXPECT_LT(fastest, 500 * kRadPerDeg) << "sway comes on top";
    EXPECT_GT(largest, 30 * kRadPerDeg);
    EXPECT_LT(largest, 75 * kRadPerDeg);
  }
}

TEST(HeadMotion, DefaultHasAMinuteOfWalkingWhereThereIsRoom) {
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (const double duration_s : {20.0, 90.0, 134.0, 600.0}) {
      const auto episodes = default_head_episodes(duration_s, Random(seed));
      double walked_s = 0;
      for (std::size_t e = 0; e < episodes.size(); ++e) {
        const double end_s = e + 1 < episodes.size() ? episodes[e + 1].begin_s : duration_s;
        EXPECT_GT(end_s, episodes[e].begin_s);
        if (episodes[e].activity == HeadActivity::walking) walked_s += end_s - episodes[e].begin_s;
      }
      EXPECT_NEAR(walked_s, std::min(60.0, 0.5 * duration_s), 0.2) << duration_s << " " << seed;
    }
}

TEST(HeadMotion, KeepsTimeCodeAndWeightsOfTheMotion) {
  face::Motion motion;
  for (int i = 0; i < 900; ++i) {
    face::MotionFrame frame;
    frame.time_s = 5 + i / 29.97;
    frame.weights[7] = 0.25F;
    motion.frames.push_back(frame);
  }
  const auto with = with_head_motion(motion, Random(2));
  EXPECT_TRUE(with.has_head);
  ASSERT_EQ(with.frames.size(), 900U);
  double largest = 0;
  for (std::size_t i = 0; i < 900; ++i) {
    EXPECT_EQ(with.frames[i].time_s, motion.frames[i].time_s);
    EXPECT_EQ(with.frames[i].weights, motion.frames[i].weights);
    largest = std::max(largest, tilt_of(with.frames[i].head));
  }
  EXPECT_GT(largest, 5 * kRadPerDeg);
  EXPECT_TRUE(with_head_motion(face::Motion{}, Random(1)).frames.empty());

  const std::array walks = {HeadEpisode{0, HeadActivity::walking}};
  const auto walking = with_head_motion(motion, walks, Random(2));
  ASSERT_EQ(walking.frames.size(), 900U);
  EXPECT_EQ(walking.frames[450].weights, motion.frames[450].weights);
  EXPECT_GT((walking.frames.back().head_position_m - walking.frames.front().head_position_m).norm(), 25);
  EXPECT_TRUE(with_head_motion(face::Motion{}, walks, Random(1)).frames.empty());
}

}  // namespace
}  // namespace mien::performer::head_motion_test
