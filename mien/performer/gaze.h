#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// What the eyes are about.
enum class GazeTask {
  still,         ///< Held on one point, with the small drift of fixation.
  conversation,  ///< Mostly ahead, glances aside.
  reading,       ///< Along lines of text, with return sweeps.
  wandering,     ///< Anywhere, with smooth pursuit now and then.
};

/// From `begin_s` until the next episode begins.
struct GazeEpisode {
  double begin_s = 0;
  GazeTask task = GazeTask::conversation;
};

/// Where the eyes look, frame by frame at 60 Hz.
struct GazeTrack {
  /// Yaw to the performer's left and pitch upwards in the head frame, rad, of both eyes' common direction.
  std::vector<Eigen::Vector2f> direction_rad;
  /// Each eye turns this much inwards, rad.
  std::vector<float> vergence_rad;
  /// When the eyes moved by more than 8 degrees, seconds, ascending.
  std::vector<double> shifts_s;
};

/// Fixations and saccades; saccades keep the main sequence (21 ms + 2.2 ms a degree: Carpenter 1988,
/// "Movements of the Eyes"). `range` scales amplitudes. `rest_rad` is where the eyes come back to.
[[nodiscard]] GazeTrack draw_gaze(std::size_t frame_count, std::span<const GazeEpisode> episodes,
                                  const Eigen::Vector2f& rest_rad, double range, Random random);

/// A full eyeLook weight in radians, in single precision.
inline constexpr auto kGazeRadiansPerUnit = static_cast<float>(face::kEyeTurnRadPerUnit);

/// Writes the eight eyeLook weights of one frame: yaw and pitch as in GazeTrack, both eyes turned inwards by
/// `vergence_rad`. Only one of each pair of opposites is above 0.
void set_eye_look(face::BlendshapeWeights& weights, const Eigen::Vector2f& direction_rad, float vergence_rad);

}  // namespace mien::performer
