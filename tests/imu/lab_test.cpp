#include <gtest/gtest.h>

#include "mien/imu/pipeline.h"
#include "tests/imu/clocked_pipeline.h"

namespace mien::imu::lab_test {
namespace {

sensor::Rig two_sensors() {
  sensor::Rig rig;
  rig.name = "two";
  rig.reference = "ear";
  sensor::Mount chin;
  chin.name = "chin";
  chin.kind = "imu";
  chin.role = "face";
  sensor::Mount brow = chin;
  brow.name = "brow";
  sensor::Mount ear = chin;
  ear.name = "ear";
  ear.role = "head";
  rig.sensors = {chin, brow, ear};
  return rig;
}

sensor::Sample lab_sample(std::uint16_t sensor, DeviceTime time, const Vec3f& rotation) {
  sensor::Sample sample;
  sample.sensor = sensor;
  sample.kind = sensor::SampleKind::imu_head_relative;
  sample.time = time;
  sample.count = 3;
  for (int i = 0; i < 3; ++i) sample.values[static_cast<std::size_t>(i)] = rotation[i];
  return sample;
}

TEST(Lab, RotationsReachTheirOwnFrameUntouched) {
  testing_head::ClockedPipeline pipeline(two_sensors());
  model::FeatureFrame frame;
  for (int i = 0; i < 30; ++i) {
    const DeviceTime time{frame_offset(i)};
    const Vec3f rotation(0.01F * static_cast<float>(i), 0.2F, -0.1F);
    pipeline.add(HostTime{frame_offset(i)}, lab_sample(0, time, rotation));
    pipeline.tick(time, frame);
    ASSERT_EQ(frame.sensors.size(), 2u);
    EXPECT_EQ(frame.time, time);
    ASSERT_TRUE(frame.sensors[0].has_rotation);
    EXPECT_FALSE(frame.sensors[0].has_accel);
    EXPECT_FALSE(frame.sensors[1].has_rotation);
    EXPECT_FALSE(frame.has_head);
    const auto& q = frame.sensors[0].rotation;
    const Vec3 back = log_rotation(Quat(q[0], q[1], q[2], q[3]));
    EXPECT_NEAR((back - rotation.cast<double>()).norm(), 0, 1e-6);
  }
}

TEST(Lab, ASilentSensorIsMissingAfterItsTimeOut) {
  testing_head::ClockedPipeline pipeline(two_sensors());
  model::FeatureFrame frame;
  pipeline.add(HostTime{}, lab_sample(0, DeviceTime{}, Vec3f(0.1F, 0, 0)));
  pipeline.tick(DeviceTime{std::chrono::milliseconds(149)}, frame);
  EXPECT_TRUE(frame.sensors[0].has_rotation);
  pipeline.tick(DeviceTime{std::chrono::milliseconds(151)}, frame);
  EXPECT_FALSE(frame.sensors[0].has_rotation);
}

TEST(Lab, UnknownSensorsAndShortSamplesAreIgnored) {
  testing_head::ClockedPipeline pipeline(two_sensors());
  model::FeatureFrame frame;
  pipeline.add(HostTime{}, lab_sample(200, DeviceTime{}, Vec3f::Zero()));
  auto shorter = lab_sample(0, DeviceTime{}, Vec3f::Zero());
  shorter.count = 2;
  pipeline.add(HostTime{}, shorter);
  pipeline.tick(DeviceTime{}, frame);
  EXPECT_FALSE(frame.sensors[0].has_rotation);
}

}  // namespace
}  // namespace mien::imu::lab_test
