#pragma once

#include <array>
#include <cstdint>

#include "mien/core/rotation.h"
#include "mien/core/time.h"
#include "mien/face/profile.h"
#include "mien/face/shape_region.h"

namespace mien::face {

/// How a value came about.
enum class Provenance : std::uint8_t { measured, interpolated, predicted, held, audio, neutral };

/// One moment of the answer: what trackers give and sinks send.
struct OutputFrame {
  DeviceTime time;                              ///< Frame time on the reference sensor's clock.
  BlendshapeWeights weights;                    ///< 0 to 1.
  std::array<float, kShapeCount> confidence{};  ///< 0 to 1, a shape.
  std::array<Provenance, kShapeCount> provenance{};
  /// Of each region (ShapeRegion): the probability that the mean absolute error of its shapes in this frame
  /// is at most 0.1 (docs/reference/metrics.md, "Confidence of a region"). 0: unknown.
  std::array<float, kShapeRegionCount> region_confidence{};
  float tongue_out = 0;  ///< 0 to 1; ARKit's tongueOut, which has no shape among the 53.

  Quat head = Quat::Identity();  ///< q_world_head.
  float head_confidence = 0;
  Provenance head_provenance = Provenance::neutral;
  /// Where the head is from where its tracker began, frame W, m; with the head's confidence and provenance.
  /// Zero unless head_position_known: only some trackers tell it.
  Eigen::Vector3f head_position_m = Eigen::Vector3f::Zero();
  bool head_position_known = false;

  /// Eye directions in the head frame: yaw to the performer's left and pitch upwards, rad; left eye, right
  /// eye.
  std::array<Eigen::Vector2f, 2> eyes_rad = {Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()};
  float eyes_confidence = 0;
  Provenance eyes_provenance = Provenance::neutral;
};

/// The neutral frame: weights 0, eyes straight ahead, head upright; confidence 0, provenance neutral.
[[nodiscard]] inline OutputFrame neutral_frame(DeviceTime time) {
  OutputFrame frame{.time = time};
  frame.provenance.fill(Provenance::neutral);
  return frame;
}
}  // namespace mien::face
