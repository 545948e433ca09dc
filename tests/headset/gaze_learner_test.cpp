// Allocations are counted, by taking the place of operator new.
#include "mien/headset/gaze_learner.h"

#include <gtest/gtest.h>

#include "tests/allocation_count.h"

namespace mien::headset::gaze_learner_test {
namespace {

constexpr int kFrames = 60;  // Of each target.

/// Every target for a second, with a gap of half a second before each.
GazeLearner asking() {
  GazeLearner learner;
  std::int64_t at = 30;
  for (const face::GazeTarget& target : face::gaze_targets()) {
    learner.ask(target, DeviceTime(frame_offset(at)), DeviceTime(frame_offset(at + kFrames)));
    at += kFrames + 30;
  }
  return learner;
}

/// Which target a frame is in, counted with its gap, and how far into it; negative: in the gap.
struct At {
  std::size_t target = 0;
  int frame = 0;
};
At at(int frame) {
  return {static_cast<std::size_t>(frame) / (kFrames + 30), frame % (kFrames + 30) - 30};
}

/// An eye that turns 0.7 of the way, and 0.1 rad too far to the left.
Eigen::Vector2f found_at(std::size_t target) {
  return 0.7F * face::gaze_targets()[target].direction_rad + Eigen::Vector2f(0.1F, 0);
}

/// Shows both eyes, the right one as it is, what `seen` lets through.
template <typename Seen>
void show(GazeLearner& learner, Seen&& seen) {
  for (int frame = 0; frame < 5 * (kFrames + 30); ++frame) {
    const At now = at(frame);
    GazeLearner::Found found;
    // In a gap the eyes are anywhere.
    const Eigen::Vector2f astray(0.4F, -0.3F);
    if (seen(now, 0)) found[0] = now.frame < 0 ? astray : found_at(now.target);
    if (seen(now, 1)) found[1] = now.frame < 0 ? astray : face::gaze_targets()[now.target].direction_rad;
    learner.add(DeviceTime(frame_offset(frame)), found);
  }
}

const sensor::Score& score(const GazeLearner::Learnt& learnt, std::string_view name) {
  for (const sensor::Score& one : learnt.scores)
    if (one.name == name) return one;
  ADD_FAILURE() << "no score " << name;
  return learnt.scores.front();
}

const auto kAll = [](At, std::size_t) { return true; };

TEST(GazeLearner, LearnsFromWhatIsFoundAtTheTargets) {
  GazeLearner learner = asking();
  EXPECT_TRUE(learner.asks());
  EXPECT_FALSE(learner.is_over(DeviceTime(frame_offset(5 * (kFrames + 30) - 1))));
  EXPECT_TRUE(learner.is_over(DeviceTime(frame_offset(5 * (kFrames + 30)))));
  show(learner, kAll);
  const auto learnt = learner.learn();
  ASSERT_TRUE(learnt.map);
  const Eigen::Vector2f elsewhere(0.15F, 0.1F);
  EXPECT_LT((learnt.map->apply(0, 0.7F * elsewhere + Eigen::Vector2f(0.1F, 0)) - elsewhere).norm(), 0.015F);
  EXPECT_EQ(learnt.map->eyes[1], GazeMap::Affine(GazeMap::Affine::Identity())) << "it was right";
  EXPECT_TRUE(sensor::all_pass(learnt.scores));
  EXPECT_EQ(score(learnt, "gaze targets").value, 1);
  EXPECT_LT(score(learnt, "gaze left").value, 2);
  EXPECT_NE(score(learnt, "gaze left").sentence.find("without it 6"), std::string::npos)
      << score(learnt, "gaze left").sentence;
  EXPECT_NEAR(score(learnt, "gaze right").value, 0, 1e-4);
}

TEST(GazeLearner, LeavesOutATargetAtWhichTheEyesWereShut) {
  GazeLearner learner = asking();
  show(learner, [](At now, std::size_t) { return now.target != 3 || now.frame < 29; });
  const auto learnt = learner.learn();
  ASSERT_TRUE(learnt.map);
  EXPECT_NE(learnt.map->eyes[0], GazeMap::Affine(GazeMap::Affine::Identity()));
  const sensor::Score& targets = score(learnt, "gaze targets");
  EXPECT_FALSE(targets.pass);
  EXPECT_NEAR(targets.value, 0.8, 1e-9);
  EXPECT_NE(targets.sentence.find("look up"), std::string::npos) << targets.sentence;
  EXPECT_EQ(targets.sentence.find("look down"), std::string::npos) << targets.sentence;
}

TEST(GazeLearner, ABlinkCostsATargetNothing) {
  GazeLearner whole = asking(), blinks = asking();
  show(whole, kAll);
  show(blinks, [](At now, std::size_t) { return now.frame < 20 || now.frame > 35; });
  EXPECT_TRUE(sensor::all_pass(blinks.learn().scores));
  EXPECT_LT((blinks.learn().map->eyes[0] - whole.learn().map->eyes[0]).norm(), 1e-5F);
}

TEST(GazeLearner, OneEyeThatIsSeenIsLearntAlone) {
  GazeLearner learner = asking();
  show(learner, [](At, std::size_t eye) { return eye == 0; });
  const auto learnt = learner.learn();
  ASSERT_TRUE(learnt.map);
  EXPECT_NE(learnt.map->eyes[0], GazeMap::Affine(GazeMap::Affine::Identity()));
  EXPECT_EQ(learnt.map->eyes[1], GazeMap::Affine(GazeMap::Affine::Identity()));
  EXPECT_TRUE(score(learnt, "gaze targets").pass) << "a camera that is not there is no target missed";
  EXPECT_EQ(learnt.scores.size(), 2U);
}

TEST(GazeLearner, LearnsNothingFromTooFewTargets) {
  GazeLearner learner = asking();
  show(learner, [](At now, std::size_t) { return now.target < 3; });
  for (const auto& learnt : {learner.learn(), asking().learn()}) {
    EXPECT_FALSE(learnt.map);
    ASSERT_EQ(learnt.scores.size(), 1U);
    EXPECT_FALSE(learnt.scores[0].pass);
    EXPECT_NE(learnt.scores[0].sentence.find("too little"), std::string::npos) << learnt.scores[0].sentence;
  }
}

TEST(GazeLearner, SaysThatTheEyesWereNotOnTheTargets) {
  GazeLearner learner = asking();
  for (int frame = 0; frame < 5 * (kFrames + 30); ++frame) {
    const Eigen::Vector2f stare(0.05F, 0);
    learner.add(DeviceTime(frame_offset(frame)), {stare, stare});
  }
  const auto learnt = learner.learn();
  EXPECT_TRUE(score(learnt, "gaze targets").pass);
  EXPECT_FALSE(score(learnt, "gaze left").pass);
  EXPECT_GT(score(learnt, "gaze left").value, 8);
}

TEST(GazeLearner, ForgetsWhatItGatheredOrWhatItAskedFor) {
  GazeLearner learner = asking();
  show(learner, kAll);
  learner.restart();
  EXPECT_TRUE(learner.asks());
  EXPECT_FALSE(learner.learn().map);
  show(learner, kAll);
  EXPECT_TRUE(learner.learn().map);
  learner.clear();
  EXPECT_FALSE(learner.asks());
  EXPECT_FALSE(learner.is_over(DeviceTime(frame_offset(9999))));
}

TEST(GazeLearner, AllocatesNothingWhileItGathers) {
  GazeLearner learner = asking();
  const std::size_t before = mien::test::allocation_count();
  show(learner, kAll);
  EXPECT_EQ(mien::test::allocation_count(), before);
}

}  // namespace
}  // namespace mien::headset::gaze_learner_test
