#include "mien/gaze/eyes.h"

#include <cstddef>

namespace mien::gaze {
namespace {

constexpr std::size_t kEyeValues = 5;
constexpr float kUnknown = -1;

bool is_within(float x, float low, float high) {
  return x >= low && x <= high;
}

std::optional<float> known(float value) {
  return value == kUnknown ? std::nullopt : std::optional(value);
}

}  // namespace

bool is_sound(const Eye& eye) {
  return is_within(eye.yaw_rad, -kMostRad, kMostRad) && is_within(eye.pitch_rad, -kMostRad, kMostRad) &&
         is_within(eye.confidence, 0, 1) && is_within(eye.openness.value_or(0), 0, 1) &&
         is_within(eye.pupil_mm.value_or(0), 0, kMostPupilMm);
}

sensor::Sample sample_of(const Eyes& eyes) {
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::gaze;
  sample.count = 2 * kEyeValues;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    float* const values = sample.values.data() + e * kEyeValues;
    values[0] = eyes[e].yaw_rad;
    values[1] = eyes[e].pitch_rad;
    values[2] = eyes[e].confidence;
    values[3] = eyes[e].openness.value_or(kUnknown);
    values[4] = eyes[e].pupil_mm.value_or(kUnknown);
  }
  return sample;
}

std::optional<Eyes> eyes_of(const sensor::Sample& sample) {
  Eyes eyes;
  if (sample.kind != sensor::SampleKind::gaze || sample.count != 2 * kEyeValues) return std::nullopt;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    const float* const values = sample.values.data() + e * kEyeValues;
    eyes[e] = {values[0], values[1], values[2], known(values[3]), known(values[4])};
    if (!is_sound(eyes[e])) return std::nullopt;
  }
  return eyes;
}

}  // namespace mien::gaze
