#pragma once

#include <array>

#include "mien/core/rotation.h"
#include "mien/face/output_frame.h"
#include "mien/face/profile.h"

namespace mien::sink {

/// An output frame in the terms that receivers share. Nothing in it is unfit to be sent: all is finite,
/// weights are 0 to 1, and mouthClose is at most jawOpen.
struct ArkitFrame {
  face::ArkitWeights weights;    ///< In face::ArkitOrder::live_link_udp.
  Quat head = Quat::Identity();  ///< q_world_head, w >= 0; +X the performer's left, +Y up, +Z forward.
  /// Where the head is from where it began or was re-centred, m, same axes, within kMostHead_m; 0 where
  /// nobody knows it.
  Vec3f head_position_m = Vec3f::Zero();
  bool head_position_known = false;
  /// Yaw to the performer's left and pitch upwards, rad, in the head's frame, within +-1.5; left eye, right
  /// eye.
  std::array<Eigen::Vector2f, 2> eyes_rad = {Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()};
  bool face_tracked = false;  ///< Some weight has another provenance than neutral.
  /// Something looks at the eyes: the provenance of their directions is measured or interpolated.
  bool eyes_tracked = false;
  /// A lid (eyeBlink) is measured, interpolated, predicted from the sensors that are there, or held.
  bool lids_tracked = false;
};

/// Largest coordinate of a head's position that is sent, each way, m.
inline constexpr float kMostHead_m = 100;

/// The rotation as it may be sent: unit, w >= 0; the identity for what is none.
[[nodiscard]] Quat sendable_rotation(const Quat& q);

/// No allocation. Thread-safe.
[[nodiscard]] ArkitFrame arkit_frame(const face::OutputFrame& frame);

}  // namespace mien::sink
