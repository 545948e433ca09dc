#include "mien/session/tap_watch.h"

#include <gtest/gtest.h>

namespace mien::session::tap_watch_test {
namespace {

using sensor::DeviceKey;
using sensor::SampleKind;

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

sensor::Reading reading(std::uint64_t device, float force_m_s2, SampleKind kind = SampleKind::imu_raw) {
  sensor::Reading reading;
  reading.from = {device, 0};
  reading.sample.kind = kind;
  const std::size_t first = kind == SampleKind::imu_raw ? 3 : 4;
  reading.sample.values[first + 1] = force_m_s2;
  reading.sample.count = static_cast<std::uint8_t>(first + 3);
  return reading;
}

/// Three devices at rest from 0 s, and what is felt at 1 s; who was tapped, and when that was said.
struct Told {
  std::optional<DeviceKey> device;
  double at_s = 0;
};
Told tap(TapWatch& watch, const std::array<float, 3>& felt_m_s2, SampleKind kind = SampleKind::imu_raw) {
  for (int i = 0; i < 480; ++i) {
    const double t = i / 240.0;
    for (std::uint64_t device = 0; device < 3; ++device) {
      const float force = 9.81F + (i == 240 ? felt_m_s2[device] : 0.0F);
      if (const auto tapped = watch.add(at(t), reading(device, force, kind))) return {tapped, t};
    }
  }
  return {};
}

TEST(TapWatch, FindsTheOneThatFeltMostAndWaitsForAllToHaveFelt) {
  for (const SampleKind kind : {SampleKind::imu_raw, SampleKind::imu_fused}) {
    TapWatch watch;
    watch.arm("mentalis");
    EXPECT_EQ(watch.armed(), "mentalis");
    const Told told = tap(watch, {12, 30, 9}, kind);
    ASSERT_TRUE(told.device);
    EXPECT_EQ(told.device->device, 1u);
    EXPECT_GT(told.at_s, 1.12);
    EXPECT_LT(told.at_s, 1.14);
  }
}

TEST(TapWatch, AFaceThatMovesIsNoTap) {
  TapWatch watch;
  watch.arm("mentalis");
  EXPECT_FALSE(tap(watch, {3, 7, 1}).device);
}

TEST(TapWatch, SaysNothingUnasked) {
  TapWatch watch;
  EXPECT_FALSE(tap(watch, {12, 30, 9}).device);
  watch.arm("mentalis");
  watch.arm("");
  EXPECT_FALSE(tap(watch, {12, 30, 9}).device);
}

TEST(TapWatch, BeginsAnewWhenItIsArmedAgain) {
  TapWatch watch;
  watch.arm("mentalis");
  EXPECT_FALSE(watch.add(at(0), reading(5, 0)));
  EXPECT_FALSE(watch.add(at(0.004), reading(5, 50)));
  watch.arm("buccinator_L");  // Half a second later nobody was tapped.
  EXPECT_FALSE(watch.add(at(0.5), reading(5, 50)));
  EXPECT_FALSE(watch.add(at(1), reading(6, 9.81F)));
  EXPECT_EQ(watch.armed(), "buccinator_L");
}

TEST(TapWatch, PassesOverWhatHasNoForceAndDevicesWithoutEnd) {
  TapWatch watch;
  watch.arm("mentalis");
  for (int i = 0; i < 100; ++i) {
    sensor::Reading lab = reading(1, static_cast<float>(50 * (i % 2)));
    lab.sample.kind = SampleKind::imu_head_relative;
    EXPECT_FALSE(watch.add(at(i / 60.0), lab));
  }
  for (std::uint64_t device = 0; device < 200; ++device) EXPECT_FALSE(watch.add(at(2), reading(device, 0)));
  EXPECT_FALSE(watch.add(at(2.1), reading(3, 40)));
  const auto tapped = watch.add(at(2.3), reading(150, 40));  // Beyond the 64 that are watched.
  ASSERT_TRUE(tapped);
  EXPECT_EQ(tapped->device, 3u);
}

}  // namespace
}  // namespace mien::session::tap_watch_test
