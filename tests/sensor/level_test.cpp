#include "mien/sensor/sample_values.h"

#include <gtest/gtest.h>

namespace mien::sensor::level_test {
namespace {

Sample of(SampleKind kind, float first, float second, std::uint8_t count) {
  Sample sample;
  sample.kind = kind;
  sample.values[0] = first;
  sample.values[1] = second;
  sample.count = count;
  return sample;
}

TEST(Level, ALightIsWhatCameBackFromItsOwn) {
  EXPECT_FLOAT_EQ(*level(of(SampleKind::eyewear_light, 0.7F, 0.2F, 2)), 0.5F);
  EXPECT_FALSE(level(of(SampleKind::eyewear_light, 0.7F, 0, 1)));
}

TEST(Level, AMicrophoneIsShownInDecibels) {
  EXPECT_NEAR(*level(of(SampleKind::sound, 1, 1, 2)), 1, 1e-5);
  EXPECT_NEAR(*level(of(SampleKind::sound, 0.0316F, 0.1F, 2)), 0.5, 1e-3);
  EXPECT_EQ(*level(of(SampleKind::sound, 0.0005F, 0.1F, 2)), 0);
  EXPECT_EQ(*level(of(SampleKind::sound, 0, 0, 2)), 0) << "silence";
}

TEST(Level, OthersHaveNone) {
  EXPECT_FALSE(level(of(SampleKind::imu_raw, 1, 0, 3)));
}

}  // namespace
}  // namespace mien::sensor::level_test
