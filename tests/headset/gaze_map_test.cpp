#include "mien/headset/gaze_map.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "mien/face/gaze_targets.h"

namespace mien::headset::gaze_map_test {
namespace {

/// What an eye shows whose true direction is known: found = gain * known + offset.
std::vector<GazeSample> looked_at(const Eigen::Matrix2f& gain, const Eigen::Vector2f& offset) {
  std::vector<GazeSample> samples;
  for (const face::GazeTarget& target : face::gaze_targets()) {
    GazeSample& sample = samples.emplace_back();
    sample.known_rad = target.direction_rad;
    sample.found_rad[0] = gain * target.direction_rad + offset;
    sample.found_rad[1] = target.direction_rad;
  }
  return samples;
}

TEST(GazeMap, UndoesAGainAndAnOffset) {
  Eigen::Matrix2f gain;
  gain << 0.7F, 0.1F, -0.05F, 0.8F;
  const Eigen::Vector2f offset(0.1F, -0.05F);
  const auto fit = fit_gaze_map(looked_at(gain, offset));
  ASSERT_TRUE(fit) << fit.error().message();
  EXPECT_TRUE(fit->kept[0]);
  EXPECT_GT(fit->before[0], 0.1);
  EXPECT_LT(fit->held_out[0], fit->before[0] / 2);
  const Eigen::Vector2f elsewhere(0.15F, 0.1F);
  const Eigen::Vector2f error = fit->map.apply(0, gain * elsewhere + offset) - elsewhere;
  EXPECT_LT(error.norm(), 0.01F);
}

TEST(GazeMap, LeavesAnEyeAloneThatIsRight) {
  const auto fit = fit_gaze_map(looked_at(0.7F * Eigen::Matrix2f::Identity(), Eigen::Vector2f::Zero()));
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->kept[1]) << "nothing can help";
  EXPECT_EQ(fit->map.eyes[1], GazeMap::Affine(GazeMap::Affine::Identity()));
  EXPECT_EQ(fit->map.apply(1, {0.25F, -0.125F}), Eigen::Vector2f(0.25F, -0.125F));
}

/// A wearer who looked elsewhere each time teaches nothing: what fits the targets does not fit those held
/// out.
TEST(GazeMap, IsNotKeptWhereItHelpsAtNoTargetButItsOwn) {
  auto samples = looked_at(Eigen::Matrix2f::Identity(), Eigen::Vector2f::Zero());
  const std::array<Eigen::Vector2f, 5> astray = {
      Eigen::Vector2f(0.08F, 0.02F), Eigen::Vector2f(-0.05F, 0.07F), Eigen::Vector2f(-0.06F, -0.06F),
      Eigen::Vector2f(0.03F, -0.08F), Eigen::Vector2f(0.00F, 0.05F)};
  for (std::size_t i = 0; i < samples.size(); ++i) *samples[i].found_rad[0] += astray[i];
  const auto fit = fit_gaze_map(samples);
  ASSERT_TRUE(fit);
  EXPECT_GE(fit->held_out[0], fit->before[0]);
  EXPECT_FALSE(fit->kept[0]);
  EXPECT_EQ(fit->map.eyes[0], GazeMap::Affine(GazeMap::Affine::Identity()));
}

TEST(GazeMap, FitsAnEyeToTheTargetsAtWhichItWasSeen) {
  auto samples = looked_at(0.7F * Eigen::Matrix2f::Identity(), Eigen::Vector2f(0.1F, 0));
  for (auto& sample : samples) sample.found_rad[1].reset();
  samples[4].found_rad[0].reset();
  const auto four = fit_gaze_map(samples);
  ASSERT_TRUE(four) << four.error().message();
  EXPECT_EQ(four->fitted, (std::array{true, false}));
  EXPECT_EQ(four->kept, (std::array{true, false}));
  EXPECT_EQ(four->map.eyes[1], GazeMap::Affine(GazeMap::Affine::Identity()));
  samples.pop_back();
  const auto same = fit_gaze_map(samples);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->map, four->map);
  samples[3].found_rad[0].reset();
  EXPECT_EQ(fit_gaze_map(samples).error().code, ErrorCode::out_of_range);
}

TEST(GazeMap, CorrectsAnAnswersDirections) {
  GazeMap map;
  map.eyes[0] << 1.5F, 0, 0.125F, 0, 1, -0.0625F;
  Answer answer;
  answer.gaze_rad = {0.25F, 0.125F, -0.25F, 0.5F};
  map.correct(answer);
  EXPECT_EQ(answer.gaze_rad, (std::array{0.5F, 0.0625F, -0.25F, 0.5F}));
  answer.gaze_rad[0] = 1;
  map.correct(answer);
  EXPECT_EQ(answer.gaze_rad[0], 1.1F) << "no eye turns farther";
  EXPECT_EQ(map.gains().apply(0, {0, 0}), Eigen::Vector2f(0, 0));
  EXPECT_EQ(map.gains().apply(0, {0.25F, 0.125F}), Eigen::Vector2f(0.375F, 0.125F));
}

TEST(GazeMap, TurnsNothingRound) {
  Eigen::Matrix2f mirrored;
  mirrored << -1, 0, 0, 1;
  const auto fit = fit_gaze_map(looked_at(mirrored, Eigen::Vector2f::Zero()));
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->kept[0]) << "eyes that are swapped are no calibration's matter";
}

TEST(GazeMap, RefusesWhatTellsTooLittle) {
  const auto samples = looked_at(Eigen::Matrix2f::Identity(), Eigen::Vector2f::Zero());
  EXPECT_EQ(fit_gaze_map(std::span(samples).first(3)).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(fit_gaze_map({}).error().code, ErrorCode::out_of_range);
  auto wrong = samples;
  wrong[2].found_rad[1]->y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(fit_gaze_map(wrong).error().code, ErrorCode::out_of_range);
}

TEST(GazeMap, GoesThroughJson) {
  const auto fit = fit_gaze_map(looked_at(0.8F * Eigen::Matrix2f::Identity(), Eigen::Vector2f(0.1F, 0)));
  ASSERT_TRUE(fit);
  const auto back = parse_gaze_map(write_gaze_map(fit->map), "map");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, fit->map);
  const auto refused = [](const char* text, ErrorCode code) {
    const auto map = parse_gaze_map(text, "map");
    ASSERT_FALSE(map) << text;
    EXPECT_EQ(map.error().code, code) << text;
  };
  for (const char* text :
       {"", "[]", "{}", R"({"gaze": 1})", R"({"gaze": [[1,0,0,0,1,0]]})",
        R"({"gaze": [[1,0,0,0,1],[1,0,0,0,1,0]]})", R"({"gaze": [[1,0,0,0,1,"0"],[1,0,0,0,1,0]]})"})
    refused(text, ErrorCode::malformed);
  for (const char* text :
       {R"({"gaze": [[1,0,9,0,1,0],[1,0,0,0,1,0]]})", R"({"gaze": [[1,0,0,0,1,0],[-1,0,0,0,1,0]]})",
        R"({"gaze": [[1,0,0,0,1e39,0],[1,0,0,0,1,0]]})", R"({"gaze": [[0.1,0,0,0,1,0],[1,0,0,0,1,0]]})"})
    refused(text, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::headset::gaze_map_test
