#include "mien/speech/spoken_mouth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::speech::spoken_mouth_test {
namespace {

constexpr std::size_t kJaw = face::shape("jawOpen");
constexpr std::size_t kClose = face::shape("mouthClose");

DeviceTime at_ms(int ms) {
  return DeviceTime(std::chrono::milliseconds(ms));
}

Heard heard(int ms, float jaw, float voice = 1) {
  Heard heard{.time = at_ms(ms), .weights = {}, .voice = voice};
  heard.weights[kJaw] = jaw;
  return heard;
}

TEST(SpokenMouth, WithoutSmoothingItIsWhatWasHeard) {
  SpokenMouth mouth;
  mouth.push(heard(0, 0.2F));
  mouth.push(heard(20, 0.6F));
  EXPECT_FLOAT_EQ(mouth.tick(at_ms(10))->weights[kJaw], 0.4F) << "between two their mean";
  EXPECT_FLOAT_EQ(mouth.tick(at_ms(30))->weights[kJaw], 0.6F);
}

TEST(SpokenMouth, AStepIsFollowedWithoutOvershoot) {
  SpokenMouth mouth(100);
  float last = 0;
  int half_ms = 0;
  for (int ms = 0; ms < 400; ms += 10) {
    if (ms % 20 == 0) mouth.push(heard(ms, ms < 100 ? 0 : 0.8F));
    const auto now = mouth.tick(at_ms(ms));
    ASSERT_TRUE(now);
    EXPECT_GE(now->weights[kJaw], last - 1e-6F);
    EXPECT_LE(now->weights[kJaw], 0.8F + 1e-6F);
    if (half_ms == 0 && now->weights[kJaw] > 0.4F) half_ms = ms;
    last = now->weights[kJaw];
  }
  EXPECT_NEAR(last, 0.8F, 1e-3);
  EXPECT_NEAR(half_ms, 90 + 17, 15) << "half of a step after 1.7 / rate";
}

TEST(SpokenMouth, ARoughMouthIsShownSmooth) {
  SpokenMouth rough, smooth(100);
  Random random(1);
  std::vector<float> a, b;
  for (int ms = 0; ms < 4000; ms += 20) {
    const Heard next =
        heard(ms, static_cast<float>(0.3 + 0.2 * std::sin(ms * 0.01) + random.uniform(-0.1, 0.1)));
    rough.push(next);
    smooth.push(next);
    a.push_back(rough.tick(at_ms(ms))->weights[kJaw]);
    b.push_back(smooth.tick(at_ms(ms))->weights[kJaw]);
  }
  const auto jerk = [](const std::vector<float>& track) {
    double sum = 0;
    for (std::size_t i = 3; i < track.size(); ++i)
      sum += std::pow(double{track[i] - 3 * track[i - 1] + 3 * track[i - 2] - track[i - 3]}, 2);
    return std::sqrt(sum);
  };
  EXPECT_LT(jerk(b), 0.5 * jerk(a));
}

TEST(SpokenMouth, ClosedLipsNeverPassTheJaw) {
  SpokenMouth mouth(100);
  Random random(2);
  for (int ms = 0; ms < 4000; ms += 20) {
    Heard next = heard(ms, static_cast<float>(random.uniform(0, 1)));
    next.closure = static_cast<float>(random.uniform(0, 1));
    next.weights[kClose] = next.closure * next.weights[kJaw];
    mouth.push(next);
    const auto now = mouth.tick(at_ms(ms));
    EXPECT_LE(now->weights[kClose], now->weights[kJaw] + 1e-5F);
    EXPECT_GE(now->weights[kClose], 0);
  }
}

TEST(SpokenMouth, NobodySpeaksAfterAPauseAndAnewItOpensFromRest) {
  SpokenMouth mouth(100);
  for (int ms = 0; ms < 200; ms += 20) mouth.push(heard(ms, 0.5F));
  EXPECT_TRUE(mouth.tick(at_ms(190)));
  for (int ms = 200; ms < 800; ms += 20) {
    mouth.push(heard(ms, 0.5F, 0.1F));
    const bool speaks = mouth.tick(at_ms(ms)).has_value();
    if (ms > 540 || ms < 480) {
      EXPECT_EQ(speaks, ms < 480) << ms;
    }
  }
  mouth.push(heard(800, 0.5F));
  EXPECT_LT(mouth.tick(at_ms(800))->weights[kJaw], 0.4F);
  mouth.reset();
  EXPECT_FALSE(mouth.tick(at_ms(810)));
}

}  // namespace
}  // namespace mien::speech::spoken_mouth_test
