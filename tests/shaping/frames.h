#pragma once

#include <cmath>
#include <cstring>

#include "mien/core/random.h"
#include "mien/shaping/bounds.h"

namespace mien::shaping {

inline DeviceTime frame_time(std::int64_t index) {
  return DeviceTime(std::chrono::seconds(7) + frame_offset(index));
}

/// A frame that a tracker measured: all weights `weight`, sure of itself.
inline face::OutputFrame measured(std::int64_t index, float weight = 0) {
  face::OutputFrame frame;
  frame.time = frame_time(index);
  frame.weights.values.fill(weight);
  frame.confidence.fill(0.9f);
  frame.provenance.fill(face::Provenance::measured);
  frame.head_confidence = 0.8f;
  frame.head_provenance = face::Provenance::measured;
  return frame;
}

/// A face that moves: each shape its own slow wave with noise, the head turning.
inline face::OutputFrame moving(std::int64_t index, Random& random) {
  face::OutputFrame frame = measured(index);
  const double t = static_cast<double>(index) / 60;
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    frame.weights[i] = static_cast<float>(0.5 + 0.45 * std::sin(t * (1 + 0.1 * static_cast<double>(i))) +
                                          random.uniform(-0.02, 0.02));
  frame.tongue_out = static_cast<float>(0.5 + 0.4 * std::sin(3 * t));
  frame.head = exp_rotation({0.2 * std::sin(t), 0.4 * std::sin(0.7 * t), 0.1});
  return frame;
}

/// The same of a head whose position is known.
inline face::OutputFrame standing_at(std::int64_t index, const Vec3f& position_m) {
  face::OutputFrame frame = measured(index);
  frame.head_position_m = position_m;
  frame.head_position_known = true;
  return frame;
}

inline bool same_bits(const face::OutputFrame& a, const face::OutputFrame& b) {
  return a.time == b.time && std::memcmp(&a.weights, &b.weights, sizeof a.weights) == 0 &&
         std::memcmp(&a.confidence, &b.confidence, sizeof a.confidence) == 0 &&
         std::memcmp(&a.region_confidence, &b.region_confidence, sizeof a.region_confidence) == 0 &&
         a.provenance == b.provenance &&
         std::memcmp(a.head.coeffs().data(), b.head.coeffs().data(), 4 * sizeof(double)) == 0 &&
         a.head_confidence == b.head_confidence && a.head_provenance == b.head_provenance &&
         a.eyes_rad[0] == b.eyes_rad[0] && a.eyes_rad[1] == b.eyes_rad[1] && a.tongue_out == b.tongue_out &&
         a.eyes_confidence == b.eyes_confidence && a.eyes_provenance == b.eyes_provenance &&
         a.head_position_known == b.head_position_known && a.head_position_m == b.head_position_m;
}

/// The largest change of a weight between two frames.
inline double largest_step(const face::OutputFrame& a, const face::OutputFrame& b) {
  double step = 0;
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    step = std::max(step, std::abs(static_cast<double>(a.weights[i]) - b.weights[i]));
  return step;
}

}  // namespace mien::shaping
