#include "mien/session/guide.h"

#include <gtest/gtest.h>

#include "mien/face/anchors.h"
#include "tests/virtual/three_sensors.h"

namespace mien::session::guide_test {
namespace {

using tracker::Step;

/// A tracker that only listens to what it is guided through.
class Guided final : public tracker::Tracker {
 public:
  struct Asked {
    Step step;
    DeviceTime begin, end;
  };
  std::vector<Asked> asked;
  std::vector<Asked> ranges;
  std::vector<tracker::PromptedExpression> expressions;
  struct Look {
    std::string_view name;
    DeviceTime begin, end;
  };
  std::vector<Look> looks;
  tracker::Guidance wanted;

  [[nodiscard]] std::string_view modality() const override { return "imu"; }
  void add(HostTime, const sensor::Sample&) override {}
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime, const sensor::TimeLines&, face::OutputFrame&) override { return {}; }
  void guide(Step step, DeviceTime begin, DeviceTime end) override { asked.push_back({step, begin, end}); }
  [[nodiscard]] tracker::Guidance guidance() const override { return wanted; }
  void guide_range(DeviceTime begin, DeviceTime end) override { ranges.push_back({Step::none, begin, end}); }
  void guide_expression(const tracker::PromptedExpression& told) override { expressions.push_back(told); }
  void guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) override {
    looks.push_back({target.name, begin, end});
  }
};

/// A session's trackers of which one remembers how it is guided.
struct Stage {
  Guided* tracker = nullptr;
  TrackerSet set;
  Stage() : Stage(std::make_unique<Guided>()) {}

 private:
  explicit Stage(std::unique_ptr<Guided> only)
      : tracker(only.get()), set(virt::test::three_sensors(), one(std::move(only))) {}
  static std::vector<std::unique_ptr<tracker::Tracker>> one(std::unique_ptr<Guided> only) {
    std::vector<std::unique_ptr<tracker::Tracker>> all;
    all.push_back(std::move(only));
    return all;
  }
};

/// Runs it from frame 600 on with a performer who does `share` of each anchor; returns the frames it took.
int lead(Guide& guide, Stage& stage, double share, int most = 20'000) {
  for (int i = 0; i < most; ++i) {
    face::OutputFrame frame;
    frame.time = DeviceTime(frame_offset(600 + i));
    guide.before(frame.time, stage.set);
    if (const Guide::Place place = guide.place(frame.time);
        place.part != nullptr && place.part->target != nullptr && place.progress > 0)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        frame.weights[k] = static_cast<float>(share) * (*place.part->target)[k];
    if (guide.after(frame)) return i;
  }
  return most;
}

TEST(Guide, AShortOneIsNeutralNodAndShakeWithTimeToRead) {
  Guide guide;
  Stage stage;
  Guided& tracker = *stage.tracker;
  EXPECT_FALSE(guide.running());
  guide.begin({.kind = Calibrate::Kind::brief});
  EXPECT_TRUE(guide.running());
  EXPECT_EQ(guide.place(DeviceTime()).part, nullptr) << "its time is not known before its first tick";
  const int frames = lead(guide, stage, 1);
  EXPECT_NEAR(frames, 60 * (1.5 + 3 + 4.5 + 4.5), 1);
  EXPECT_FALSE(guide.running());
  EXPECT_TRUE(guide.anchor_scores().empty());
  ASSERT_EQ(tracker.asked.size(), 3u);
  EXPECT_EQ(tracker.asked[0].step, Step::neutral);
  EXPECT_EQ(tracker.asked[1].step, Step::nod);
  EXPECT_EQ(tracker.asked[2].step, Step::shake);
  EXPECT_EQ(tracker.asked[0].begin, DeviceTime(frame_offset(600)) + std::chrono::milliseconds(1500));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(tracker.asked[i].end, tracker.asked[i + 1].begin);
}

TEST(Guide, AFullOneScoresEachAnchorByHowMuchOfItCameThrough) {
  Guide guide;
  Stage stage;
  Guided& tracker = *stage.tracker;
  guide.begin({.kind = Calibrate::Kind::full});
  const int frames = lead(guide, stage, 0.6);
  EXPECT_NEAR(frames, 60 * (13.5 + 2.4 * static_cast<double>(face::anchors().size())), 1);
  EXPECT_EQ(tracker.asked.size(), 3u) << "the tracker has no use for anchors";
  ASSERT_EQ(guide.anchor_scores().size(), face::anchors().size());
  for (const sensor::Score& score : guide.anchor_scores()) {
    EXPECT_TRUE(score.name.starts_with("anchor ")) << score.name;
    EXPECT_NEAR(score.value, 0.6, 1e-5) << score.name;
    EXPECT_TRUE(score.pass) << score.name;
  }

  guide.begin({.kind = Calibrate::Kind::full});
  lead(guide, stage, 0.1);
  for (const sensor::Score& score : guide.anchor_scores()) EXPECT_FALSE(score.pass) << score.name;

  guide.begin({.kind = Calibrate::Kind::brief});
  EXPECT_TRUE(guide.anchor_scores().empty()) << "those of the last run";
}

TEST(Guide, AsksForWhatTheTrackerWantsAndTellsItOfTheRangeOfMotion) {
  Guide guide;
  Stage stage;
  Guided& tracker = *stage.tracker;
  tracker.wanted = {.neutral = std::chrono::seconds(5), .gestures = false};
  guide.begin({.kind = Calibrate::Kind::brief});
  EXPECT_NEAR(lead(guide, stage, 1), 60 * (1.5 + 5), 1);
  ASSERT_EQ(tracker.asked.size(), 1u);
  EXPECT_EQ(tracker.asked[0].step, Step::neutral);
  EXPECT_TRUE(tracker.ranges.empty()) << "a short one has none";

  guide.begin({.kind = Calibrate::Kind::full});
  EXPECT_NEAR(lead(guide, stage, 1), 60 * (6.5 + 2.4 * static_cast<double>(face::anchors().size())), 1);
  ASSERT_EQ(tracker.asked.size(), 2u);
  ASSERT_EQ(tracker.ranges.size(), 1u);
  EXPECT_EQ(tracker.ranges[0].begin, tracker.asked[1].end);
  EXPECT_NEAR(to_seconds(tracker.ranges[0].end - tracker.ranges[0].begin),
              2.4 * static_cast<double>(face::anchors().size()), 1e-9);
  EXPECT_EQ(guide.anchor_scores().size(), face::anchors().size());
}

TEST(Guide, OneThatLearnsTheWearerTellsTheTrackerOfEachExpression) {
  Guide guide;
  Stage stage;
  Guided& tracker = *stage.tracker;
  guide.begin({.kind = Calibrate::Kind::wearer});
  const double asked_s = 2.4 * static_cast<double>(face::anchors().size()) +
                         2.0 * static_cast<double>(face::range_of_motion().size());
  EXPECT_NEAR(lead(guide, stage, 1), 60 * (13.5 + asked_s + to_seconds(tracker::kWearerLearnt) + 0.5), 1);
  ASSERT_EQ(tracker.expressions.size(), face::anchors().size() + face::range_of_motion().size());
  EXPECT_EQ(tracker.expressions.front().begin, tracker.asked.back().end);
  for (std::size_t i = 0; i + 1 < tracker.expressions.size(); ++i)
    EXPECT_EQ(tracker.expressions[i].end, tracker.expressions[i + 1].begin);
  EXPECT_EQ(tracker.expressions.back().target, face::range_of_motion().back().target);
  ASSERT_EQ(tracker.ranges.size(), 1u);
  EXPECT_EQ(tracker.ranges[0].end, tracker.expressions.back().end) << "the learning is no expression";
  EXPECT_EQ(guide.anchor_scores().size(), face::anchors().size()) << "the others are not judged one by one";
}

TEST(Guide, OneOfGazeAsksForTargetsAfterTheNeutralAndGivesTimeToLookThere) {
  Guide guide;
  Stage stage;
  Guided& tracker = *stage.tracker;
  tracker.wanted = {.neutral = std::chrono::seconds(3), .gestures = false, .learns_gaze = true};
  guide.begin({.kind = Calibrate::Kind::gaze});
  const auto targets = face::gaze_targets();
  const auto count = static_cast<double>(targets.size());
  EXPECT_NEAR(lead(guide, stage, 1), 60 * (1.5 + 3 + 2.7 * count), 1);
  ASSERT_EQ(tracker.asked.size(), 1u);
  EXPECT_TRUE(tracker.ranges.empty()) << "eyes that turn are no range of motion";
  EXPECT_TRUE(guide.anchor_scores().empty());
  ASSERT_EQ(tracker.looks.size(), targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const DeviceTime shown = tracker.asked[0].end + i * std::chrono::milliseconds(2700);
    EXPECT_EQ(tracker.looks[i].name, targets[i].name);
    EXPECT_EQ(tracker.looks[i].begin, shown + std::chrono::milliseconds(900)) << "they turn there first";
    EXPECT_EQ(tracker.looks[i].end, shown + std::chrono::milliseconds(2700));
    const Guide::Part& part = guide.parts()[i + 1];
    EXPECT_EQ(part.look, &targets[i]);
    EXPECT_EQ(part.prompt, targets[i].prompt);
    EXPECT_EQ(part.target, nullptr);
  }
}

TEST(Guide, TellsWhereItIs) {
  Guide guide;
  Stage stage;
  guide.begin({.kind = Calibrate::Kind::full});
  const DeviceTime begin(frame_offset(600));
  guide.before(begin, stage.set);
  ASSERT_EQ(guide.parts().size(), 3 + face::anchors().size());
  const Guide::Place lead_in = guide.place(begin);
  ASSERT_NE(lead_in.part, nullptr);
  EXPECT_EQ(lead_in.part->name, "neutral");
  EXPECT_EQ(lead_in.progress, 0);
  EXPECT_EQ(lead_in.remaining, std::chrono::milliseconds(4500));
  const Guide::Place half = guide.place(begin + std::chrono::milliseconds(3000));
  EXPECT_EQ(half.number, 1u);
  EXPECT_NEAR(half.progress, 0.5, 1e-9);
  EXPECT_EQ(guide.place(begin + std::chrono::milliseconds(4500)).part->name, "nod");
  const Guide::Place anchor = guide.place(begin + std::chrono::milliseconds(15'000));
  EXPECT_EQ(anchor.number, 4u);
  ASSERT_NE(anchor.part->target, nullptr);
  EXPECT_EQ(anchor.part->prompt, face::anchors().front().prompt);
  EXPECT_EQ(guide.place(begin + std::chrono::hours(1)).part, nullptr);

  guide.cancel();
  EXPECT_FALSE(guide.running());
  EXPECT_TRUE(guide.parts().empty());
  face::OutputFrame frame;
  frame.time = begin + std::chrono::hours(1);
  EXPECT_FALSE(guide.after(frame));
}

TEST(Guide, FollowsStepsWhoseTimesAreGiven) {
  Guide guide;
  Stage stage;
  const auto at = [](int frame) { return DeviceTime(frame_offset(600 + frame)); };
  const face::GazeTarget& left = face::gaze_targets()[1];
  guide.begin({.steps = {{.step = Step::neutral, .begin = at(10), .end = at(100)},
                         {.step = Step::nod, .begin = at(110), .end = at(200)},
                         {.range = true, .begin = at(210), .end = at(300)},
                         {.look = &left, .begin = at(310), .end = at(400)}}});
  EXPECT_EQ(lead(guide, stage, 1), 400);
  const Guided& tracker = *stage.tracker;
  ASSERT_EQ(tracker.asked.size(), 2u);
  EXPECT_EQ(tracker.asked[1].step, Step::nod);
  EXPECT_EQ(tracker.asked[1].begin, at(110));
  ASSERT_EQ(tracker.ranges.size(), 1u);
  EXPECT_EQ(tracker.ranges[0].end, at(300));
  ASSERT_EQ(tracker.looks.size(), 1u);
  EXPECT_EQ(tracker.looks[0].name, left.name);
  EXPECT_EQ(tracker.looks[0].begin, at(310));
  EXPECT_TRUE(guide.anchor_scores().empty());
}

}  // namespace
}  // namespace mien::session::guide_test
