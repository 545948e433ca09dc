#include "mien/phone/taps.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/core/time.h"

// A finger on the chin, which shakes sensors there and pushes the jaw that a phone sees. No virtual performer
// taps, and no phone's recording of a tap was at hand: these are drawn here.
namespace mien::phone::taps_test {
namespace {

constexpr std::size_t kJaw = face::shape("jawOpen");
constexpr double kTakeS = 90, kPhoneFromS = 17.25, kPhoneS = 65;
using Taps = std::vector<double>;

/// A pulse of 40 ms.
double pulse(double off_s) {
  return std::exp(-0.5 * off_s * off_s / (0.02 * 0.02));
}

/// Two sensors that feel speech and noise, of which the first is on the chin; taps at sensors' times.
std::vector<model::FeatureFrame> felt(const Taps& taps) {
  Random random(4);
  std::vector<model::FeatureFrame> frames;
  for (int f = 0; f < kTakeS * kFrameRateHz; ++f) {
    const double time_s = f / kFrameRateHz;
    model::FeatureFrame& frame = frames.emplace_back();
    frame.time = DeviceTime(from_seconds(50) + frame_offset(f));
    double jolt = std::sin(2 * 3.14159 * 3 * time_s) + random.normal(0, 0.2);
    for (const double tap : taps) jolt += 12 * pulse(time_s - tap);
    for (const double share : {1.0, 0.2})
      frame.sensors.push_back(
          {.accel_m_s2 = Vec3f(0, 0, static_cast<float>(share * jolt)), .has_accel = true});
  }
  return frames;
}

/// A phone that began kPhoneFromS after the sensors, before a jaw that rests; taps at sensors' times.
face::Motion told(const Taps& taps, bool by_the_head = false) {
  Random random(5);
  face::Motion motion{.name = "a phone", .frames = {}, .has_head = by_the_head};
  for (int f = 0; f < kPhoneS * 60; ++f) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = f / 60.0;
    double push = 0;
    for (const double tap : taps) push += pulse(frame.time_s + kPhoneFromS - tap - 0.02);
    frame.weights[kJaw] = static_cast<float>(0.05 + random.normal(0, 0.001) + (by_the_head ? 0 : 0.1 * push));
    if (by_the_head) frame.head = exp_rotation({0.05 * push, 0, 0});
  }
  return motion;
}

Taps three(double from_s, double first_gap_s = 0.4, double second_gap_s = 0.5) {
  return {from_s, from_s + first_gap_s, from_s + first_gap_s + second_gap_s};
}

Taps joined(Taps a, const Taps& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Taps, TellTheOffset) {
  for (const bool by_the_head : {false, true}) {
    const auto prior = prior_by_taps(felt(three(20)), told(three(20), by_the_head));
    ASSERT_TRUE(prior) << by_the_head;
    EXPECT_NEAR(prior->offset_s, kPhoneFromS - 0.02, 0.02);
    EXPECT_EQ(prior->offset_window_s, AlignmentPrior{}.offset_window_s);
  }
  // And at the end.
  const auto late = prior_by_taps(felt(three(78)), told(three(78)));
  ASSERT_TRUE(late);
  EXPECT_NEAR(late->offset_s, kPhoneFromS - 0.02, 0.02);
}

TEST(Taps, OfOneRhythmAtBothEndsTellOneOffset) {
  const Taps both = joined(three(20), three(78));
  const auto prior = prior_by_taps(felt(both), told(both));
  ASSERT_TRUE(prior);
  EXPECT_NEAR(prior->offset_s, kPhoneFromS - 0.02, 0.02);
}

TEST(Taps, OfWhichNoOneKnowsWhichIsWhichTellNothing) {
  // The phone saw one of two that are alike.
  EXPECT_FALSE(prior_by_taps(felt(joined(three(20), three(40))), told(three(20))));
  // Of two rhythms it is clear.
  EXPECT_TRUE(prior_by_taps(felt(joined(three(20), three(40, 0.3, 0.3))), told(three(20))));
}

TEST(Taps, ThatOneAloneSawTellNothing) {
  EXPECT_FALSE(prior_by_taps(felt(three(20)), told({})));
  EXPECT_FALSE(prior_by_taps(felt({}), told(three(20))));
  EXPECT_FALSE(prior_by_taps(felt(three(20, 0.4, 0.5)), told(three(20, 0.5, 0.4)))) << "another rhythm";
  EXPECT_FALSE(prior_by_taps(felt(three(50)), told(three(50)))) << "in the middle of what the phone recorded";
  EXPECT_FALSE(prior_by_taps({}, told(three(20))));
  EXPECT_FALSE(prior_by_taps(felt(three(20)), {}));
}

TEST(Taps, AreThreeAndNeitherMoreNorSlower) {
  for (const Taps& taps :
       {Taps{20, 20.4}, Taps{20, 20.4, 20.8, 21.2}, Taps{20, 21, 22}, Taps{20, 20.1, 20.2}})
    EXPECT_FALSE(prior_by_taps(felt(taps), told(taps))) << taps.size() << " " << taps.back();
}

TEST(Taps, AreFoundBesideAFrameOfAnotherYear) {
  auto frames = felt(three(20));
  const auto plain = prior_by_taps(frames, told(three(20)));
  // Jolts for every 60th of a year would be 15 GB, and of a century more than there is.
  for (const double years : {1.0, 100.0}) {
    frames.push_back(frames.back());
    frames.back().time += from_seconds(365 * 86'400 * years);
  }
  const auto prior = prior_by_taps(frames, told(three(20)));
  ASSERT_TRUE(plain && prior);
  EXPECT_EQ(prior->offset_s, plain->offset_s);
  // A pause is no matter either, nor times that run back.
  for (std::size_t i = 10 * 60; i < frames.size() - 2; ++i) frames[i].time += from_seconds(3600);
  const auto later = prior_by_taps(frames, told(three(20)));
  ASSERT_TRUE(later);
  EXPECT_NEAR(later->offset_s, plain->offset_s + 3600, 1e-6);
  std::swap(frames.front().time, frames.back().time);
  EXPECT_TRUE(prior_by_taps(frames, told(three(20))));
}

TEST(Taps, BeforeTheCalibrationAreNotFelt) {
  auto frames = felt(three(20));
  for (model::FeatureFrame& frame : std::span(frames).first(30 * 60))
    for (model::SensorFeature& sensor : frame.sensors) sensor = {};
  EXPECT_FALSE(prior_by_taps(frames, told(three(20))));
}

}  // namespace
}  // namespace mien::phone::taps_test
