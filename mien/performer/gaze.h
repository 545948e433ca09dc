#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// Behaviour of the eyes.
enum class GazeTask {
  still,         ///< Fixed on one point, with fixational drift.
  conversation,  ///< Mostly ahead, glances aside.
  reading,       ///< Along lines of text, with return sweeps.
  wandering,     ///< Anywhere, with occasional smooth pursuit.
};

/// From `begin_s` until the next episode begins.
struct GazeEpisode {
  double begin_s = 0;
  GazeTask task = GazeTask::conversation;
};

/// Gaze, frame by frame at 60 Hz.
struct GazeTrack {
  /// Common direction of both eyes, frame H: yaw to the performer's left and pitch upwards, rad.
  std::vector<Eigen::Vector2f> direction_rad;
  /// Inward turn of each eye, rad.
  std::vector<float> vergence_rad;
  /// Times of gaze shifts above 8 degrees, seconds, ascending.
  std::vector<double> shifts_s;
};

/// Fixations and saccades; saccade durations follow the main sequence (21 ms + 2.2 ms a degree: Carpenter
/// 1988, "Movements of the Eyes"). `range` scales amplitudes (around 1). `rest_rad`: the resting direction.
[[nodiscard]] GazeTrack draw_gaze(std::size_t frame_count, std::span<const GazeEpisode> episodes,
                                  const Eigen::Vector2f& rest_rad, double range, Random random);

/// Writes the eight eyeLook weights of one frame: yaw and pitch as in GazeTrack, both eyes turned inwards by
/// `vergence_rad`. Only one of each pair of opposites is above 0.
void set_eye_look(face::BlendshapeWeights& weights, const Eigen::Vector2f& direction_rad, float vergence_rad);

}  // namespace mien::performer
