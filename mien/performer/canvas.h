#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "mien/core/minimum_jerk.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// One gesture in time: rises, holds, falls. Seconds from the canvas's start.
struct Envelope {
  double begin_s = 0;
  double rise_s = 0.2;
  double hold_s = 0;
  double fall_s = 0.3;

  [[nodiscard]] double end_s() const { return begin_s + rise_s + hold_s + fall_s; }
  /// 0 to 1.
  [[nodiscard]] double at(double time_s) const {
    const double t = time_s - begin_s;
    if (t < rise_s) return minimum_jerk(t / rise_s);
    return 1 - minimum_jerk((t - rise_s - hold_s) / fall_s);
  }
};

/// One shape of a pose and how far it goes.
struct PosePart {
  std::uint8_t shape = 0;  ///< Inner profile.
  float weight = 0;        ///< 0 to 1.
};
/// A sparse set of weights.
using Pose = std::vector<PosePart>;

/// How poses are written down: "mouthSmile" means both sides, "mouthSmile_L" one, "jawOpen" the middle.
struct NamedPart {
  std::string_view stem;
  float weight = 0;
};
/// Stops the program on a name that is no shape: tables are checked by the tests that use them.
[[nodiscard]] Pose pose_of(std::initializer_list<NamedPart> parts);

/// The other side's shape; the shape itself where it has no sides. Opposites such as jawLeft are no sides.
[[nodiscard]] std::size_t other_side(std::size_t shape_of_one_side);

/// What a performer means to do, frame by frame at 60 Hz, before the person's own style, blinks and limits.
/// Layers add into it.
struct Canvas {
  explicit Canvas(std::size_t frame_count);

  std::vector<face::BlendshapeWeights> weights;
  std::vector<float> tongue_out;
  /// 0 to 1; where it is 1 the lips meet, whatever the jaw does.
  std::vector<float> lip_closure;
  /// Asked of the eyes on top of their own wandering: yaw to the performer's left and pitch upwards, rad.
  std::vector<Eigen::Vector2f> gaze_rad;
  /// 0 to 1: how far the eyes' own wandering is held down.
  std::vector<float> gaze_held;
  /// Head gestures of speech: rotation about X (nod down), Y (to the left), Z, rad.
  std::vector<Vec3> head_rad;
  /// Moments at which people like to blink, seconds.
  std::vector<double> pauses_s;

  [[nodiscard]] std::size_t frame_count() const { return weights.size(); }
  [[nodiscard]] double duration_s() const { return static_cast<double>(weights.size()) / kFrameRateHz; }

  /// Adds `peak` x `envelope` to one shape.
  void add(std::size_t shape, const Envelope& envelope, double peak);
  /// The same for all of a pose.
  void add(const Pose& pose, const Envelope& envelope, double peak);
  void add_tongue(const Envelope& envelope, double peak);
  /// Lays `part` over this canvas from `first_frame` (may be negative) on, faded in and out over
  /// `fade_frames`; what lies outside is cut, and a cut end is not faded.
  void lay(const Canvas& part, std::ptrdiff_t first_frame, std::size_t fade_frames);
};

/// White noise through two equal one-pole low-passes, at 60 Hz: mean 0, standard deviation 1.
class SmoothNoise {
 public:
  /// `cutoff_hz` of each pole, 0.01 to 20.
  SmoothNoise(double cutoff_hz, Random& random);
  double next(Random& random);

 private:
  double keep_;
  double scale_;
  double first_;
  double second_;
};

}  // namespace mien::performer
