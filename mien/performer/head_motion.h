#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/motion.h"

namespace mien::performer {

/// Activity of the head.
enum class HeadActivity {
  still,    ///< Held, with postural sway.
  nodding,  ///< Nods of 5 to 20 degrees at 0.4 to 1.2 Hz.
  turning,  ///< Turns, tilts and looks up and down, to +-20 degrees and back.
  talking,  ///< Small continuous movement of a speaker.
  walking,  ///< 1.7 to 2.1 steps a second, +-2 cm up and down, along a wandering path.
  running,  ///< 2.6 to 3 steps a second, 4 to 6 cm, with the shock of each step.
  darting,  ///< Quick looks aside, to +-45 degrees at up to 400 degrees a second, and shakes at 2 to 3.2 Hz.
};

/// From `begin_s` until the next episode begins.
struct HeadEpisode {
  double begin_s = 0;
  HeadActivity activity = HeadActivity::still;
};

/// Head pose, frame by frame at 60 Hz.
struct HeadTrack {
  std::vector<Quat> orientation;  ///< q_world_head.
  std::vector<Vec3> position_m;   ///< Head origin, frame W; zero at upright rest.
};

/// Yaw about +Y (to the performer's left), then pitch about +X (nod down), then roll about +Z; radians, as
/// (pitch, yaw, roll).
[[nodiscard]] Quat head_orientation(const Vec3& pitch_yaw_roll_rad);
/// Displacement of the head origin, m, frame W, by a rotation about the upper neck.
[[nodiscard]] Vec3 neck_displacement_m(const Quat& q_world_head);

/// Simulates `episodes` at 60 Hz, crossfaded over a second. `liveliness` scales talk and sway (around 1);
/// `extra_rad`, added: empty, or (pitch, yaw, roll) a frame, for gestures of speech.
[[nodiscard]] HeadTrack draw_head_motion(std::size_t frame_count, std::span<const HeadEpisode> episodes,
                                         double liveliness, std::span<const Vec3> extra_rad, Random random);

/// Default episodes: stillness, nods and turns to +-20 degrees, and a minute of walking among them (half the
/// duration where that is below two minutes).
[[nodiscard]] std::vector<HeadEpisode> default_head_episodes(double duration_s, Random random);

/// `motion` with the default head motion instead of its own; the time code is kept.
[[nodiscard]] face::Motion with_head_motion(const face::Motion& motion, Random random);
/// The same with these episodes, counted from the motion's first frame.
[[nodiscard]] face::Motion with_head_motion(const face::Motion& motion, std::span<const HeadEpisode> episodes,
                                            const Random& random);

}  // namespace mien::performer
