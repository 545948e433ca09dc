#include "lab/headset/seen_film.h"

#include <gtest/gtest.h>

#include <vector>

#include "mien/face/face.h"

namespace mien::lab::seen_film_test {
namespace {

/// A tracker that only listens to where it is told that eyes rest.
class Told final : public tracker::Tracker {
 public:
  struct Look {
    Eigen::Vector2f direction_rad;
    DeviceTime begin, end;
  };
  std::vector<Look> looks;

  [[nodiscard]] std::string_view modality() const override { return "none"; }
  void add(HostTime, const sensor::Sample&) override {}
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime, const sensor::TimeLines&, face::OutputFrame&) override { return {}; }
  void guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) override {
    looks.push_back({target.direction_rad, begin, end});
  }
};

TEST(TaughtGaze, TheEyesRestWhereATrackerIsToldThatTheyDo) {
  const face::Motion motion = gaze_targets_motion(Random(3));
  EXPECT_EQ(motion.frames.size(), static_cast<std::size_t>(kTaughtGaze_s * kFrameRateHz));
  Told told;
  const DeviceTime begin(std::chrono::seconds(4));
  guide_gaze_targets(begin, told);
  ASSERT_EQ(told.looks.size(), face::gaze_targets().size());
  EXPECT_EQ(told.looks.back().end, begin + from_seconds(kTaughtGaze_s));
  for (const Told::Look& look : told.looks) {
    std::size_t frames = 0;
    for (const face::MotionFrame& frame : motion.frames) {
      const DeviceTime at = begin + from_seconds(frame.time_s);
      if (at < look.begin || at >= look.end) continue;
      ++frames;
      EXPECT_LT((face::eyes_rad(frame.weights)[0] - look.direction_rad).norm(), 0.06F);
    }
    EXPECT_GE(frames, 45u);
  }
}

}  // namespace
}  // namespace mien::lab::seen_film_test
