#pragma once

#include <array>
#include <cstdint>

#include "mien/core/one_euro.h"
#include "mien/face/profile.h"

namespace mien::tracker {

/// Jitter filter behind a causal network, whose outputs follow the sensors' noise. Per shape, on frames of
/// 1/60 s: a One Euro filter (Casiez et al. 2012), a first-order low-pass, and a lead by the smoothed speed
/// that compensates part of both delays. Lids (eyeBlink_L, _R) skip the low-pass and have a lead of their
/// own, only while they close fast. Formulas and trade-offs: docs/method/live_model.md, "Jitter filter"; how
/// the constants were chosen: docs/experiments/live_model.md. One performance. No allocation.
class JitterFilter {
 public:
  /// One Euro: cutoff at rest, Hz, and its growth, Hz per weight a second. Raising the cutoff: less delay at
  /// rest, more jitter; raising beta: less delay in movement, more noise in it; lowering: the reverse. With
  /// the low-pass it takes the third difference from ten times the truth's to about the truth's, for 3 % of
  /// squared error.
  static constexpr OneEuroSettings kSettings{.min_cutoff_hz = 0.4, .beta = 4};
  /// Coefficient of the low-pass, per frame, 0 to 1 (0.4: 6 Hz). Raising: less delay, more jitter; 1: no
  /// low-pass. One pole alone leaves steps in the speed, and so jitter.
  static constexpr float kLowPassGain = 0.4F;
  /// Lead by the speed, s, and the coefficient of the speed's smoothing, per frame. Raising the lead: less
  /// error in movement, more jitter; raising the smoothing coefficient: the lead follows sooner, more jitter.
  static constexpr float kLead = 0.035F;
  static constexpr float kSpeedGain = 0.2F;
  /// Lead of the lids, since the network detects a blink when half of it is over: kBlinkLead, s, times the
  /// closing speed above kBlinkThreshold, 1/s. Raising the threshold: fewer lids lead. Raising the lead:
  /// blinks nearer in time, more overshoot.
  static constexpr float kBlinkThreshold = 1.8F;
  static constexpr float kBlinkLead = 0.05F;

  JitterFilter() { filters_.fill(OneEuro(kSettings)); }

  /// Filters the next frame's weights in place, to [0, 1]; the first frame's stay.
  void apply(face::BlendshapeWeights& weights);
  /// Resets the state.
  void reset() { *this = {}; }

 private:
  std::array<OneEuro, face::kShapeCount> filters_;
  face::BlendshapeWeights last_;                  // The last frame's filtered weights, before the lead.
  std::array<float, face::kShapeCount> speed_{};  // Of all but the lids, 1/s.
  std::int64_t frames_ = 0;
};

}  // namespace mien::tracker
