#include "mien/performer/eating.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/core/time.h"
#include "mien/core/units.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"

namespace mien::performer::eating_test {
namespace {

using face::shape;

constexpr double kSeconds = 240;

Style person(std::uint64_t taste) {
  Style style = plain_style();
  style.taste = taste;
  return style;
}

Canvas meal(std::uint64_t taste, std::uint64_t seed) {
  Canvas canvas(static_cast<std::size_t>(kSeconds * kFrameRateHz));
  perform_eating(canvas, person(taste), Random(seed));
  return canvas;
}

/// Rounds of the jaw a second, while the lips have been closed for some seconds.
double pace_hz(const Canvas& canvas) {
  std::size_t closed = 0, chewed = 0, rounds = 0;
  float before = 0;
  for (std::size_t i = 0; i < canvas.frame_count(); ++i) {
    closed = canvas.lip_closure[i] > 0.99F ? closed + 1 : 0;
    const float jaw = canvas.weights[i][shape("jawOpen")];
    if (closed > 60) {
      ++chewed;
      if (before < 0.06F && jaw >= 0.06F) ++rounds;
    }
    before = jaw;
  }
  return static_cast<double>(rounds) * kFrameRateHz / static_cast<double>(chewed);
}

TEST(Eating, ChewsAtThePaceOfThePerson) {
  double slowest = 10, fastest = 0;
  for (std::uint64_t taste = 0; taste < 8; ++taste) {
    const double pace = pace_hz(meal(taste, 1));
    EXPECT_GT(pace, 0.85) << taste;
    EXPECT_LT(pace, 2.3) << taste;
    EXPECT_NEAR(pace_hz(meal(taste, 2)), pace, 0.2) << "another meal of the same person, " << taste;
    slowest = std::min(slowest, pace);
    fastest = std::max(fastest, pace);
  }
  EXPECT_GT(fastest - slowest, 0.2);
}

TEST(Eating, TheJawComesBackUpFromTheSide) {
  const Canvas canvas = meal(3, 1);
  double up = 0, down = 0, largest = 0;
  for (std::size_t i = 1; i < canvas.frame_count(); ++i) {
    if (canvas.lip_closure[i] < 0.99F) continue;
    const auto& now = canvas.weights[i];
    const double aside = std::max(now[shape("jawLeft")], now[shape("jawRight")]);
    largest = std::max(largest, aside);
    const float opened = now[shape("jawOpen")] - canvas.weights[i - 1][shape("jawOpen")];
    (opened < 0 ? up : down) += aside * std::abs(opened);
  }
  EXPECT_GT(largest, 0.15);
  EXPECT_GT(up, 1.5 * down);
}

TEST(Eating, LipsAreClosedWhileItIsChewedAndOpenForABite) {
  const auto motion = perform(default_script(Block::eating, kSeconds), person(4), Random(1));
  std::size_t closed = 0, open = 0;
  for (const auto& frame : motion.frames) {
    const float jaw = frame.weights[shape("jawOpen")];
    if (jaw > 0.02F && frame.weights[shape("mouthClose")] > 0.98F * jaw) ++closed;
    if (jaw - frame.weights[shape("mouthClose")] > 0.3F) ++open;
  }
  const auto all = static_cast<double>(motion.frames.size());
  EXPECT_GT(static_cast<double>(closed) / all, 0.35);
  EXPECT_GT(open, 60U);
  EXPECT_LT(static_cast<double>(open) / all, 0.2);
}

TEST(Eating, HeadAndEyesGoToTheHandAndBackWithTheCup) {
  const Canvas canvas = meal(5, 1);
  double down = 0, back = 0;
  float lowest = 0;
  for (std::size_t i = 0; i < canvas.frame_count(); ++i) {
    down = std::max(down, canvas.head_rad[i].x());
    back = std::min(back, canvas.head_rad[i].x());
    lowest = std::min(lowest, canvas.gaze_rad[i].y());
  }
  EXPECT_GT(down, 3 * kRadPerDeg);
  EXPECT_LT(back, -8 * kRadPerDeg);
  EXPECT_GT(back, -40 * kRadPerDeg);
  EXPECT_LT(lowest, -12 * kRadPerDeg);
}

}  // namespace
}  // namespace mien::performer::eating_test
