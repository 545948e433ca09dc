#include "mien/imu/ready_rotations.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <limits>

namespace mien::imu {
namespace {

constexpr std::array<std::uint16_t, 2> kFace = {4, 7};
constexpr Duration kSilence = std::chrono::milliseconds(150);

sensor::Sample rotation_of(std::uint16_t sensor, DeviceTime time, const Vec3f& rotation) {
  sensor::Sample sample;
  sample.sensor = sensor;
  sample.kind = sensor::SampleKind::imu_head_relative;
  sample.time = time;
  sample.count = 3;
  for (int i = 0; i < 3; ++i) sample.values[static_cast<std::size_t>(i)] = rotation[i];
  return sample;
}

model::FeatureFrame features_at(const ReadyRotations& ready, DeviceTime frame) {
  model::FeatureFrame out;
  out.sensors.resize(kFace.size());
  ready.put(frame, out);
  return out;
}

TEST(ReadyRotations, ReachTheirOwnFrameUntouched) {
  ReadyRotations ready(kFace, kSilence);
  for (int i = 0; i < 30; ++i) {
    const DeviceTime time{frame_offset(i)};
    const Vec3f rotation(0.01F * static_cast<float>(i), 0.2F, -0.1F);
    ready.add(rotation_of(4, time, rotation));
    const model::FeatureFrame frame = features_at(ready, time);
    ASSERT_TRUE(frame.sensors[0].has_rotation);
    EXPECT_FALSE(frame.sensors[0].has_accel);
    EXPECT_FALSE(frame.sensors[1].has_rotation);
    const auto& q = frame.sensors[0].rotation;
    const Vec3 back = log_rotation(Quat(q[0], q[1], q[2], q[3]));
    EXPECT_NEAR((back - rotation.cast<double>()).norm(), 0, 1e-6);
  }
}

TEST(ReadyRotations, ASilentSensorIsMissingAfterItsTimeOut) {
  ReadyRotations ready(kFace, kSilence);
  ready.add(rotation_of(4, DeviceTime{}, Vec3f(0.1F, 0, 0)));
  EXPECT_TRUE(features_at(ready, DeviceTime{std::chrono::milliseconds(149)}).sensors[0].has_rotation);
  EXPECT_FALSE(features_at(ready, DeviceTime{std::chrono::milliseconds(151)}).sensors[0].has_rotation);
}

TEST(ReadyRotations, AForgottenSensorIsMissing) {
  ReadyRotations ready(kFace, kSilence);
  ready.add(rotation_of(4, DeviceTime{}, Vec3f(0.1F, 0, 0)));
  ready.forget(4);
  EXPECT_FALSE(features_at(ready, DeviceTime{}).sensors[0].has_rotation);
}

TEST(ReadyRotations, IgnoresOtherSensorsOtherKindsShortSamplesAndWhatIsNotFinite) {
  ReadyRotations ready(kFace, kSilence);
  ready.add(rotation_of(200, DeviceTime{}, Vec3f::Zero()));
  sensor::Sample wrong = rotation_of(4, DeviceTime{}, Vec3f::Zero());
  wrong.count = 2;
  ready.add(wrong);
  wrong = rotation_of(4, DeviceTime{}, Vec3f::Zero());
  wrong.kind = sensor::SampleKind::imu_raw;
  ready.add(wrong);
  ready.add(rotation_of(4, DeviceTime{}, Vec3f(0, std::numeric_limits<float>::quiet_NaN(), 0)));
  EXPECT_FALSE(features_at(ready, DeviceTime{}).sensors[0].has_rotation);
}

}  // namespace
}  // namespace mien::imu
