#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mien/core/time.h"

namespace mien::sensor {

/// What the values of a sample are. The room that decodes a packet gives the kind; takes store it without
/// knowing. Numbers are part of the take format: never reused.
enum class SampleKind : std::uint8_t {
  imu_raw = 1,    ///< gyro rad/s (3), specific force m/s^2 (3), optionally magnetic field tesla (3); frame S.
  imu_fused = 2,  ///< q_world_sensor w,x,y,z (4), specific force m/s^2 (3); frame S.
  imu_head_relative =
      3,  ///< Skin rotation from neutral in the head frame, rotation vector, rad (3): the lab profile.
  eyewear_light =
      4,     ///< Light at a photo-reflective sensor, LED on and LED off (2), as shares of full scale, 0 to 1.
  gaze = 5,  ///< Where both eyes look (10): order and units in mien/gaze/eyes.h.
  weights = 6,             ///< Some of a face's weights as another program tells them: order in mien/phone.
  weights_confidence = 7,  ///< Their confidences, likewise.
  head_pose = 8,           ///< Head position, frame W, m (3), q_world_head w,x,y,z (4), mien/phone's (3).
  sound = 9,     ///< A block of sound: root mean square and peak, shares of full scale, 0 to 1 (2); the block
                 ///< itself is the sample's payload (mien/speech).
  picture = 10,  ///< A camera's picture (7): order and units in mien/headset; its features, or the picture
                 ///< itself, are the sample's payload.
};

/// Whether samples of a kind stand at frames' own times: no clock is estimated from them, no delay is waited
/// for.
constexpr bool is_on_frame_time(SampleKind kind) {
  return kind == SampleKind::imu_head_relative;
}

inline constexpr std::size_t kMaxSampleValues = 16;

/// One reading of one sensor at one device time.
struct Sample {
  std::uint16_t sensor = 0;  ///< Index into the rig's sensors.
  SampleKind kind = SampleKind::imu_raw;
  std::uint32_t sequence = 0;   ///< The packet's sequence number; all samples of a packet share it.
  DeviceTime time;              ///< Middle of the reading, the sensor's own clock.
  bool time_estimated = false;  ///< True when the wire carries no device time and it was estimated.
  std::uint8_t count = 0;       ///< How many values are valid.
  std::array<float, kMaxSampleValues> values{};  ///< SI; meaning by kind.

  [[nodiscard]] std::span<const float> used() const { return {values.data(), count}; }
};

}  // namespace mien::sensor
