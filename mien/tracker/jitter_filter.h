#pragma once

#include <array>
#include <cstdint>

#include "mien/core/one_euro.h"
#include "mien/face/profile.h"

namespace mien::tracker {

/// Takes the trembling out of what a causal network answers, which follows its sensors' noise, and lets lids
/// fall in time: a One Euro filter a shape on frames a 60th of a second apart; behind it a plain low-pass for
/// all but the lids, which gives back by the speed some of what both delay; and lids that close quickly are
/// shown where they are going. One performance's. No allocation.
class JitterFilter {
 public:
  /// Together with the low-pass this takes the third difference from ten times the truth's to about the
  /// truth's, for 3 % of squared error (docs/experiments/live_model.md).
  static constexpr OneEuroSettings kSettings{.min_cutoff_hz = 0.4, .beta = 4};
  /// Of the low-pass, per frame: 6 Hz. One pole leaves steps in the speed, of which the third difference is
  /// made.
  static constexpr float kFollow = 0.4F;
  /// What is shown is this much later in a shape's course, s, by its speed; and the share of the way that
  /// this speed goes to a new one in a frame.
  static constexpr float kLead = 0.035F;
  static constexpr float kSpeedFollow = 0.2F;
  /// A network is sure of a blink when half of it is over. A lid that closes faster than this, 1/s, is shown
  /// this much later in its course, s, by so much of its speed as is above it.
  static constexpr float kBlinkSpeed = 1.8F;
  static constexpr float kBlinkLead = 0.05F;

  JitterFilter() { filters_.fill(OneEuro(kSettings)); }

  /// The next frame's weights; the first frame's stay as they are.
  void apply(face::BlendshapeWeights& weights);
  /// Forgets the performance.
  void reset() { *this = {}; }

 private:
  std::array<OneEuro, face::kShapeCount> filters_;
  face::BlendshapeWeights last_;                  // What the last frame was told, before any lead.
  std::array<float, face::kShapeCount> speed_{};  // Of all but the lids, 1/s.
  std::int64_t frames_ = 0;
};

}  // namespace mien::tracker
