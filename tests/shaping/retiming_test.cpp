#include "mien/shaping/retiming.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::shaping::retiming_test {
namespace {

/// A jaw that speaks, at any time: the same for the same seed.
class Jaw {
 public:
  explicit Jaw(std::uint64_t seed) {
    Random random(seed);
    for (double t = 0; t < 600; t += random.uniform(0.12, 0.35))
      syllables_.push_back({t, random.uniform(0.1, 0.6)});
  }
  [[nodiscard]] float at(double t) const {
    double open = 0;
    for (const auto& [middle, how] : syllables_)
      if (std::abs(t - middle) < 0.2) open += how * std::exp(-0.5 * std::pow((t - middle) / 0.05, 2));
    return static_cast<float>(std::min(open, 1.0));
  }

 private:
  std::vector<std::pair<double, double>> syllables_;
};

/// Sound whose jaw comes `lag_s` after the face's.
void play(Retiming& retiming, const Jaw& jaw, double lag_s, double from_s, double until_s) {
  for (double t = from_s; t < until_s; t += 1 / kFrameRateHz)
    retiming.push(jaw.at(t + to_seconds(retiming.offset()) - lag_s), jaw.at(t));
}

TEST(Retiming, FollowsWhatSoundLagsBehind) {
  for (const double lag_s : {0.12, -0.08, 0.0}) {
    Retiming retiming;
    const Jaw jaw(1);
    play(retiming, jaw, lag_s, 0, 60);
    EXPECT_TRUE(retiming.follows());
    EXPECT_NEAR(to_seconds(retiming.offset()), lag_s, 0.005) << lag_s;
  }
}

TEST(Retiming, MovesByFiveMillisecondsASecondAtMost) {
  Retiming retiming;
  const Jaw jaw(2);
  double last_ms = 0;
  for (int second = 0; second < 40; ++second) {
    play(retiming, jaw, 0.2, second, second + 1);
    const double now_ms = 1e3 * to_seconds(retiming.offset());
    EXPECT_LE(std::abs(now_ms - last_ms), 5.2);
    last_ms = now_ms;
  }
  EXPECT_GT(last_ms, 100);
}

TEST(Retiming, WhatIsNotHeardYetIsNotAskedFor) {
  // A listener whose newest answer is 40 ms old, whatever it is asked for; its sound lags, or comes early.
  for (const double lag_s : {0.1, 0.0, -0.12}) {
    Retiming retiming;
    const Jaw jaw(6);
    for (double t = 0; t < 90; t += 1 / kFrameRateHz) {
      const double asked = t + to_seconds(retiming.offset()), told = std::min(asked, t - 0.04);
      retiming.push(jaw.at(told - lag_s), jaw.at(t), from_seconds(asked - told));
    }
    EXPECT_NEAR(to_seconds(retiming.offset()), std::min(lag_s, 0.0), 0.012) << lag_s;
  }
}

TEST(Retiming, StaysWhereNothingIsToBeBelieved) {
  Retiming retiming;
  const Jaw jaw(3), other(4);
  play(retiming, jaw, 0.1, 0, 60);
  const Duration before = retiming.offset();
  // Two that have nothing to do with each other, one that stands still, and nobody at all.
  for (int i = 0; i < 3000; ++i) {
    const double t = 60 + i / kFrameRateHz;
    retiming.push(i < 1500 ? other.at(t) : 0.2F, jaw.at(t));
  }
  // What was known of before went out of the window meanwhile.
  EXPECT_FALSE(retiming.follows());
  EXPECT_NEAR(to_seconds(retiming.offset()), to_seconds(before), 0.03);
  const Duration frozen = retiming.offset();
  for (int i = 0; i < 3000; ++i) retiming.push(std::nullopt, 0.3F);
  EXPECT_FALSE(retiming.follows());
  EXPECT_EQ(retiming.offset(), frozen);
}

TEST(Retiming, AToneOfTheJawHasNoLag) {
  // Of equal syllables at an equal pace several lags fit as well.
  Retiming retiming;
  for (int i = 0; i < 3000; ++i) {
    const double t = i / kFrameRateHz;
    const auto jaw = [](double s) { return static_cast<float>(0.3 + 0.2 * std::sin(2 * M_PI * 8 * s)); };
    retiming.push(jaw(t - 0.05), jaw(t));
  }
  EXPECT_FALSE(retiming.follows());
  EXPECT_EQ(retiming.offset(), Duration::zero());
}

TEST(Retiming, BeginsAnew) {
  Retiming retiming;
  const Jaw jaw(5);
  play(retiming, jaw, 0.1, 0, 60);
  retiming.reset();
  EXPECT_EQ(retiming.offset(), Duration::zero());
  EXPECT_FALSE(retiming.follows());
}

}  // namespace
}  // namespace mien::shaping::retiming_test
