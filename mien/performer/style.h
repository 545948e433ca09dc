#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// Whether the ICT shape moves the mouth or the jaw.
[[nodiscard]] bool is_mouth_or_jaw(std::size_t shape);

/// Coupling of shapes in a person: `to` += `amount` x `from`.
struct Habit {
  std::uint8_t from = 0;
  std::uint8_t to = 0;
  float amount = 0;
  bool operator==(const Habit&) const = default;
};

/// Individual style of a virtual person. Drawn from assumed distributions (docs/method/performer.md); nothing
/// is measured on a real take. Raising a factor "around 1" scales that motion up, lowering scales it down.
struct Style {
  /// Gain of each shape, sides different; around 1.
  std::array<float, face::kShapeCount> gain{};
  /// Share of a sided shape that the other side follows: 0 (can wink) to 1 (cannot).
  std::array<float, face::kShapeCount> side_leak{};
  /// Resting weights; neutral (w = 0) is another pose, held on request.
  face::BlendshapeWeights rest;
  /// Resting gaze: yaw to the performer's left, pitch upwards, rad.
  Eigen::Vector2f rest_gaze_rad = Eigen::Vector2f::Zero();
  /// Couplings: smile -> cheekSquint -> eyeSquint, jaw -> lower lip, and slight random ones.
  std::vector<Habit> habits;
  /// Scale of all expressions; around 1.
  float expressiveness = 1;
  /// Speed of gestures; around 1, larger is faster.
  float tempo = 1;
  /// Spontaneous blinks a minute at rest, 10 to 25.
  float blink_rate_per_min = 16;
  /// Weight of a full blink, 0.75 to 1.
  float blink_peak = 0.95F;
  /// eyeBlink per unit of eyeLookDown: lids follow the eyes.
  float lid_follow = 0.3F;
  /// Standard deviation of the tremor of held shapes, weight.
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

/// A random person; the same state of `random` gives the same person.
[[nodiscard]] Style draw_style(Random& random);

/// No asymmetry, couplings, rest or tremor: intended motion is performed exactly. For tests and studies.
[[nodiscard]] Style plain_style();

}  // namespace mien::performer
