#pragma once

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

/// One shape of a pose and its weight.
struct PosePart {
  std::uint8_t shape = 0;  ///< Index of the ICT shape, 0 to 52.
  float weight = 0;        ///< 0 to 1.
};
/// A sparse set of weights.
using Pose = std::vector<PosePart>;

/// Notation of poses: "mouthSmile" is both sides, "mouthSmile_L" one, "jawOpen" an unsided shape.
struct NamedPart {
  std::string_view stem;
  float weight = 0;
};
/// Aborts on an unknown name: tables are checked by the tests that use them.
[[nodiscard]] Pose pose_of(std::initializer_list<NamedPart> parts);

/// The shape of the other side; the same for unsided shapes (opposites such as jawLeft included).
[[nodiscard]] std::size_t other_side(std::size_t shape_of_one_side);

/// Whether a shape is never meant by itself: the gaze model moves eyeLook, mouthClose corrects jawOpen.
[[nodiscard]] bool is_driven_by_others(std::size_t shape);

/// Intended motion at 60 Hz, before the person's style, blinks and limits. Layers add to it. All tracks have
/// frame_count() entries.
struct Canvas {
  explicit Canvas(std::size_t frame_count);

  std::vector<face::BlendshapeWeights> weights;
  std::vector<float> tongue_out;
  /// 0 to 1: at 1 the lips meet, whatever the jaw does.
  std::vector<float> lip_closure;
  /// Added to the gaze model's direction: yaw to the performer's left and pitch upwards, rad.
  std::vector<Eigen::Vector2f> gaze_rad;
  /// 0 to 1: how far the gaze model's own motion is suppressed.
  std::vector<float> gaze_held;
  /// Head gestures of speech: rotation about X (nod down), Y (to the left), Z, rad.
  std::vector<Vec3> head_rad;
  /// Cues for blinks, seconds.
  std::vector<double> pauses_s;

  [[nodiscard]] std::size_t frame_count() const { return weights.size(); }
  [[nodiscard]] double duration_s() const { return static_cast<double>(weights.size()) / kFrameRateHz; }

  /// Adds `peak` x `envelope` to one shape.
  void add(std::size_t shape, const Envelope& envelope, double peak);
  /// The same for all shapes of a pose.
  void add(const Pose& pose, const Envelope& envelope, double peak);
  void add_tongue(const Envelope& envelope, double peak);
  /// Adds `part` from `first_frame` on (may be negative), faded in and out over `fade_frames`; frames outside
  /// are cut, and a cut end is not faded.
  void lay(const Canvas& part, std::ptrdiff_t first_frame, std::size_t fade_frames);
};

/// White noise through two equal one-pole low-passes, at 60 Hz: mean 0, standard deviation 1.
class SmoothNoise {
 public:
  /// `cutoff_hz`: of each pole, 0.01 to 20.
  SmoothNoise(double cutoff_hz, Random& random);
  double next(Random& random);

 private:
  double keep_;
  double scale_;
  double first_;
  double second_;
};

}  // namespace mien::performer
