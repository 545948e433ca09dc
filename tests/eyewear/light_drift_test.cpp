#include "mien/eyewear/light_drift.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/eyewear/normalisation.h"
#include "tests/eyewear/glasses.h"

namespace mien::eyewear::light_drift_test {
namespace {

constexpr double kFrame_s = 1 / kFrameRateHz;

/// The second of three sensors is followed.
sensor::Rig rig() {
  sensor::Rig out = test::glasses_rig(3);
  out.sensors[1].recentre = true;
  return out;
}

LightFrame features(float value) {
  return {{value, value, value}, {1, 1, 1}};
}

/// Plays one value for so long; what the second sensor's last feature became.
float play(LightDrift& drift, double seconds, float value) {
  LightFrame light;
  for (double t = 0; t < seconds; t += kFrame_s) {
    light = features(value);
    drift.apply(kFrame_s, light);
    EXPECT_EQ(light.values[0], value) << "not asked for: not a bit changes";
    EXPECT_EQ(light.values[2], value);
  }
  return light.values[1];
}

TEST(LightDrift, TakesOffWhereASensorUsuallyIs) {
  LightDrift drift(rig());
  EXPECT_EQ(play(drift, 9.9, 0.2F), 0.2F) << "ten seconds tell nothing yet";
  EXPECT_NEAR(play(drift, 5, 0.2F), 0.1F, 0.005) << "by 0.02 a second";
  EXPECT_NEAR(play(drift, 20, 0.2F), 0, 1.0 / 63) << "within half a bin, of two ranges in 63 steps";
  EXPECT_NEAR(drift.drifted(1), 0.2F, 1.0 / 63);
  EXPECT_EQ(drift.drifted(0), 0);
  // The mode goes over as soon as the other value is the more frequent one of 30 s.
  play(drift, 15, -0.1F);
  EXPECT_NEAR(drift.drifted(1), 0.2F, 0.01);
  EXPECT_NEAR(play(drift, 30, -0.1F), 0, 1.0 / 63);
}

TEST(LightDrift, FollowsADriftUnderExpressions) {
  LightDrift drift(rig());
  LightFrame light;
  float rest = 0;
  for (int i = 0; i < 60 * 240; ++i) {
    rest = 0.0012F * static_cast<float>(i) / 60;  // 0.29 in four minutes.
    // A second of every three the face does something.
    const float moved = i % 180 < 60 ? 0.6F * std::sin(0.05F * static_cast<float>(i % 180)) : 0;
    light = features(rest + moved);
    drift.apply(kFrame_s, light);
  }
  EXPECT_NEAR(drift.drifted(1), rest, 0.05) << "half a window and a bin late";
}

TEST(LightDrift, AHeldExpressionIsNoRest) {
  LightDrift drift(rig());
  EXPECT_EQ(play(drift, 60, 0.8F), 0.8F);
  EXPECT_EQ(play(drift, 60, 3.0F), 3.0F) << "nor is what lies beyond the histogram";
  EXPECT_EQ(play(drift, 60, -3.0F), -3.0F);
}

TEST(LightDrift, KeepsWhatItLearntOfASensorThatIsMissing) {
  LightDrift drift(rig());
  play(drift, 30, 0.25F);
  const float before = drift.drifted(1);
  for (int i = 0; i < 600; ++i) {
    LightFrame light = {{0.5F, 0, 0.5F}, {1, 0, 1}};
    drift.apply(kFrame_s, light);
    EXPECT_EQ(light.values[1], 0);
  }
  EXPECT_EQ(drift.drifted(1), before);
  drift.reset();
  EXPECT_EQ(drift.drifted(1), 0);
  EXPECT_EQ(play(drift, 1, 0.25F), 0.25F);
}

TEST(LightDrift, StaysWithinTheFeaturesRange) {
  constexpr auto kLimit = static_cast<float>(SensorNormalisation::kLimit);
  LightDrift drift(rig());
  play(drift, 60, -0.4F);
  LightFrame light = features(kLimit);
  drift.apply(kFrame_s, light);
  EXPECT_EQ(light.values[1], kLimit);
}

}  // namespace
}  // namespace mien::eyewear::light_drift_test
