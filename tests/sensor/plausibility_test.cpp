#include "mien/sensor/plausibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/core/random.h"

namespace mien::sensor::plausibility_test {
namespace {

/// A sensor of 60 samples a second for some time: its clock goes `rate` times as fast as the host's, and it
/// measures `force_m_s2` along one axis.
struct Play {
  double rate = 1;
  float force_m_s2 = 9.8F;
  SampleKind kind = SampleKind::imu_raw;
  double delay_s = 0.03;  // Mean of the radio's.
};
Plausibility play(const Play& how, double seconds) {
  Plausibility judged;
  Random random(7);
  HostTime newest;
  for (double t = 0; t < seconds; t += 1 / 60.0) {
    Sample sample;
    sample.kind = how.kind;
    sample.time = DeviceTime(from_seconds(100 + how.rate * t));
    sample.count = 6;
    sample.values[3] = how.force_m_s2;
    newest = std::max(newest, HostTime(from_seconds(t + random.exponential(how.delay_s))));
    judged.add(newest, sample);
  }
  return judged;
}

TEST(Plausibility, ASensorIsOneAfterTwoWindows) {
  EXPECT_FALSE(play({}, 1.5).is_plausible());
  EXPECT_FALSE(play({}, 1.5).is_implausible());
  EXPECT_TRUE(play({}, 2.5).is_plausible());
  EXPECT_FALSE(play({}, 20).is_implausible());
  EXPECT_TRUE(play({.rate = 1 + 500e-6}, 20).is_plausible());
  EXPECT_TRUE(play({.force_m_s2 = 12}, 20).is_plausible()) << "somebody who runs";
}

TEST(Plausibility, NoSensorMeasuresThis) {
  for (const float force : {0.0F, 1.0F, 30.0F})
    EXPECT_TRUE(play({.force_m_s2 = force}, 2.5).is_implausible());
  EXPECT_TRUE(play({.force_m_s2 = 0, .kind = SampleKind::eyewear_light}, 2.5).is_plausible())
      << "light has no gravity";
}

TEST(Plausibility, NoClockGoesLikeThis) {
  for (const double rate : {16.0, 0.0, 1.5, -1.0}) EXPECT_TRUE(play({.rate = rate}, 2.5).is_implausible());
  // One that leaps by an hour every second and a half.
  Plausibility leaping;
  for (double t = 0; t < 5; t += 1 / 60.0) {
    Sample sample;
    sample.time = DeviceTime(from_seconds(t + 3600 * std::floor(t / 1.5)));
    sample.values[3] = 9.8F;
    leaping.add(HostTime(from_seconds(t)), sample);
  }
  EXPECT_TRUE(leaping.is_implausible());
}

TEST(Plausibility, ABoardThatRestartsOnceIsStillOne) {
  Plausibility board;
  for (double t = 0; t < 8; t += 1 / 60.0) {
    Sample sample;
    sample.time = DeviceTime(from_seconds(t < 4 ? 500 + t : t - 4));
    sample.values[3] = 9.8F;
    board.add(HostTime(from_seconds(t)), sample);
    EXPECT_FALSE(board.is_implausible());
  }
  EXPECT_TRUE(board.is_plausible());
}

}  // namespace
}  // namespace mien::sensor::plausibility_test
