#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// Whether the ICT shape moves the mouth or the jaw.
[[nodiscard]] bool is_mouth_or_jaw(std::size_t shape);

/// One shape that follows another in this person: `to` gains `amount` times `from`.
struct Habit {
  std::uint8_t from = 0;
  std::uint8_t to = 0;
  float amount = 0;
  bool operator==(const Habit&) const = default;
};

/// What makes one virtual person move unlike another. All of it is drawn; nothing is measured on a real take.
struct Style {
  /// Strength of each shape, sides unlike; around 1.
  std::array<float, face::kShapeCount> gain{};
  /// How far the idle side of a shape follows the busy one: 0 (can wink) to 1 (cannot).
  std::array<float, face::kShapeCount> side_leak{};
  /// Where the face rests; neutral (w = 0) is another pose, held on request.
  face::BlendshapeWeights rest;
  /// Where the eyes rest: yaw to the performer's left, pitch upwards, rad.
  Eigen::Vector2f rest_gaze_rad = Eigen::Vector2f::Zero();
  /// Shapes that go together: smile -> cheekSquint -> eyeSquint, jaw -> lower lip, and slight ones of no
  /// reason.
  std::vector<Habit> habits;
  /// How large everything is; around 1.
  float expressiveness = 1;
  /// How fast gestures are; around 1, larger is faster.
  float tempo = 1;
  /// Spontaneous blinks a minute at rest, 10 to 25.
  float blink_rate_per_min = 16;
  /// Weight of a full blink, 0.75 to 1.
  float blink_peak = 0.95F;
  /// eyeBlink that a unit of eyeLookDown brings: lids follow the eyes.
  float lid_follow = 0.3F;
  /// Standard deviation of the tremor of muscles that hold still, in weight.
  float micro_motion = 0.005F;
  /// Size of head gestures; around 1.
  float head_liveliness = 1;
  /// Size of eye movements; around 1.
  float gaze_range = 1;
  /// Mouth opening in speech; around 1.
  float articulation = 1;
  /// Speech rate; around 1, larger is faster.
  float speech_rate = 1;
  /// Seeds the person's own variant of every expression.
  std::uint64_t taste = 0;

  bool operator==(const Style&) const = default;
};

/// Draws a person. The same state of `random` gives the same person.
[[nodiscard]] Style draw_style(Random& random);

/// No asymmetry, no habits, no rest, no tremor: what was meant is what is done. For tests and for studies.
[[nodiscard]] Style plain_style();

}  // namespace mien::performer
