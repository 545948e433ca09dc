#pragma once

#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/profile.h"

namespace mien::face {

/// One moment of a performance, as truth knows it.
struct MotionFrame {
  double time_s = 0;                    ///< From the motion's start.
  BlendshapeWeights weights;            ///< As performed; not clipped.
  float tongue_out = 0;                 ///< 0 to 1.
  Quat head = Quat::Identity();         ///< q_world_head: the head's turn from upright and forward.
  Vec3 head_position_m = Vec3::Zero();  ///< Head origin in the world, for walking.
  bool has_face = true;  ///< False where the source lost the face; weights are then meaningless.
};

/// A performance: a Live Link CSV, a take's truth, or a virtual performer's script played out.
struct Motion {
  std::string name;
  std::vector<MotionFrame> frames;  ///< time_s strictly increasing.
  bool has_head = false;            ///< False when the source's head columns are all zero.
  bool head_without_face =
      false;  ///< The head is known in frames without a face too: it did not come from a camera.

  [[nodiscard]] double duration_s() const { return frames.empty() ? 0 : frames.back().time_s; }
};

/// Plays a motion at any time: weights by monotone cubic on its own time code, the head by a cubic without
/// steps in its speed; before the start and after the end it holds. A gap without a face is bridged, and
/// has_face says so; a head that is known there goes on.
class MotionCurve {
 public:
  explicit MotionCurve(const Motion& motion);
  [[nodiscard]] MotionFrame at(double time_s) const;
  [[nodiscard]] double duration_s() const { return time_s_.empty() ? 0 : time_s_.back(); }

 private:
  struct Head {
    double time_s = 0;
    Quat orientation;
    Vec3 position_m;
  };
  void put_head(double time_s, MotionFrame& out) const;

  std::vector<double> time_s_;            // Frames with a face only.
  std::vector<MotionFrame> frames_;       // The same.
  std::vector<Head> heads_;               // Frames with a head.
  std::vector<BlendshapeWeights> slope_;  // Per second.
  std::vector<float> tongue_slope_;
  std::vector<std::pair<double, double>> lost_s_;  // Open intervals without a face.
};

}  // namespace mien::face
