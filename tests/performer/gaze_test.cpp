#include "mien/performer/gaze.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/time.h"
#include "mien/core/units.h"

namespace mien::performer::gaze_test {
namespace {

using face::shape;

const Eigen::Vector2f kAhead = Eigen::Vector2f::Zero();

TEST(Gaze, EachTaskFillsEveryFrameWithinReach) {
  for (const GazeTask task :
       {GazeTask::still, GazeTask::conversation, GazeTask::reading, GazeTask::wandering}) {
    const std::array episodes = {GazeEpisode{0, task}};
    const GazeTrack track = draw_gaze(3600, episodes, kAhead, 1.0, Random(1));
    ASSERT_EQ(track.direction_rad.size(), 3600U);
    ASSERT_EQ(track.vergence_rad.size(), 3600U);
    for (const auto& direction : track.direction_rad) {
      EXPECT_LT(std::abs(direction.x()), 36 * kRadPerDeg);
      EXPECT_LT(std::abs(direction.y()), 36 * kRadPerDeg);
    }
    EXPECT_TRUE(std::ranges::is_sorted(track.shifts_s));
  }
}

TEST(Gaze, StillEyesHardlyMoveAndWanderingOnesDo) {
  const auto spread = [](GazeTask task) {
    const std::array episodes = {GazeEpisode{0, task}};
    double sum = 0;
    for (const auto& direction : draw_gaze(3600, episodes, kAhead, 1.0, Random(2)).direction_rad)
      sum += direction.squaredNorm() / 3600;
    return std::sqrt(sum);
  };
  EXPECT_LT(spread(GazeTask::still), 1.5 * kRadPerDeg);
  EXPECT_GT(spread(GazeTask::wandering), 8 * kRadPerDeg);
}

TEST(Gaze, FixationsOutnumberMovingFrames) {
  const std::array episodes = {GazeEpisode{0, GazeTask::conversation}};
  const auto track = draw_gaze(7200, episodes, kAhead, 1.0, Random(3));
  int still = 0;
  for (std::size_t i = 1; i < track.direction_rad.size(); ++i)
    still += (track.direction_rad[i] - track.direction_rad[i - 1]).norm() < 0.3 * kRadPerDeg ? 1 : 0;
  EXPECT_GT(still, 7200 * 0.8);
}

TEST(Gaze, SaccadesKeepTheMainSequence) {
  // No saccade beats 700 degrees a second, and large ones exceed 150.
  const std::array episodes = {GazeEpisode{0, GazeTask::wandering}};
  const auto track = draw_gaze(7200, episodes, kAhead, 1.0, Random(4));
  double fastest = 0;
  for (std::size_t i = 1; i < track.direction_rad.size(); ++i)
    fastest = std::max<double>(fastest,
                               (track.direction_rad[i] - track.direction_rad[i - 1]).norm() * kFrameRateHz);
  EXPECT_LT(fastest, 800 * kRadPerDeg);
  EXPECT_GT(fastest, 150 * kRadPerDeg);
}

TEST(Gaze, ReadingRunsRightwardsAndSweepsBack) {
  const std::array episodes = {GazeEpisode{0, GazeTask::reading}};
  const auto track = draw_gaze(3600, episodes, kAhead, 1.0, Random(5));
  int rightwards = 0;
  int sweeps = 0;
  for (std::size_t i = 6; i < track.direction_rad.size(); i += 6) {
    const float step = track.direction_rad[i].x() - track.direction_rad[i - 6].x();
    rightwards += step < -0.5 * kRadPerDeg ? 1 : 0;
    sweeps += step > 6 * kRadPerDeg ? 1 : 0;
  }
  EXPECT_GT(rightwards, 5 * sweeps);
  EXPECT_GT(sweeps, 5);
}

TEST(Gaze, WeightsFollowDirections) {
  face::BlendshapeWeights weights;
  set_eye_look(weights, {0.3F, -0.2F}, 0.0F);
  EXPECT_FLOAT_EQ(weights[shape("eyeLookOut_L")], 0.3F / 0.611F);  // Leftwards: the left eye outwards,
  EXPECT_FLOAT_EQ(weights[shape("eyeLookIn_R")], 0.3F / 0.611F);   // the right one inwards.
  EXPECT_EQ(weights[shape("eyeLookIn_L")], 0.0F);
  EXPECT_EQ(weights[shape("eyeLookOut_R")], 0.0F);
  EXPECT_FLOAT_EQ(weights[shape("eyeLookDown_L")], 0.2F / 0.611F);
  EXPECT_EQ(weights[shape("eyeLookUp_R")], 0.0F);
  set_eye_look(weights, {0.0F, 0.0F}, 0.05F);
  EXPECT_FLOAT_EQ(weights[shape("eyeLookIn_L")], 0.05F / 0.611F);
  EXPECT_FLOAT_EQ(weights[shape("eyeLookIn_R")], 0.05F / 0.611F);
}

}  // namespace
}  // namespace mien::performer::gaze_test
