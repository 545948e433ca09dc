#pragma once

#include <array>
#include <cstdint>

#include "mien/core/one_euro.h"
#include "mien/face/profile.h"

namespace mien::tracker {

/// How a causal network's answers are filtered. Chosen on virtual people whom no page reports
/// (docs/experiments/settings.md).
struct JitterSettings {
  /// Hz, > 0: the One Euro filter's cutoff at rest, at the reference noise. Raising: less delay at rest, more
  /// jitter.
  double cutoff_hz = 0.4;
  /// Hz per weight a second: growth of that cutoff with the speed. Raising: less delay in movement, more
  /// noise in it.
  double beta = 5;
  /// Hz, > 0: cutoff at which the speed is smoothed. Raising: the filter opens sooner as a movement begins,
  /// and opens with noise.
  double speed_cutoff_hz = 6;
  /// Hz, > 0: cutoff of the low-pass behind, at the reference noise. One pole alone leaves steps in the
  /// speed, of which jitter is made. Raising: less delay, more jitter.
  double low_pass_hz = 7;
  /// The noise level at which both cutoffs are as above: mean absolute third difference of a weight over four
  /// frames. They are inversely proportional to the level. Raising: wider everywhere.
  float reference_noise = 0.012F;
  /// Share by which the level follows each frame, 0 to 1 (0.024: 0.7 s). Raising: follows sooner, and takes
  /// movement for noise.
  float noise_gain = 0.024F;
};

/// Online estimate of how noisy a network's answers are: the mean absolute third difference, which movement
/// hardly has, over the shapes that have any (one held at 0 or 1 shows no noise), averaged over time. A frame
/// counts at most kOutlier times the level, so that quick movement is not taken for noise. Deterministic; no
/// allocation.
class NoiseLevel {
 public:
  static constexpr float kOutlier = 2.5F;

  /// `initial`: the level until there are four frames, > 0. `gain`: JitterSettings::noise_gain.
  NoiseLevel(float initial, float gain) : level_(initial), gain_(gain) {}

  /// The level after the next frame's answer, 1/60 s after the last. One that is not finite changes nothing.
  float add(const face::BlendshapeWeights& answer);

 private:
  float level_, gain_;
  std::array<face::BlendshapeWeights, 3> last_;  // The three frames before, newest first.
  int frames_ = 0;                               // Of those, up to 3.
};

/// Jitter filter behind a causal network, whose outputs follow the sensors' noise. Per shape, on frames of
/// 1/60 s: a One Euro filter (Casiez et al. 2012) and a first-order low-pass, both the wider the less noise
/// the answers have (NoiseLevel), so that what hardly trembles is hardly delayed. Lids (eyeBlink_L, _R) pass
/// a One Euro filter of their own alone and have a lead, only while they close fast. Formulas and trade-offs:
/// docs/method/live_model.md, "Jitter filter". One performance. No allocation.
class JitterFilter {
 public:
  /// The cutoffs' factor stays within these, whatever the noise.
  static constexpr float kNarrowest = 0.3F, kWidest = 50;
  /// Of the lids: One Euro.
  static constexpr OneEuroSettings kLidSettings{.min_cutoff_hz = 0.4, .beta = 4};
  /// Lead of the lids, since the network detects a blink when half of it is over: kBlinkLead, s, times the
  /// closing speed above kBlinkThreshold, 1/s. Raising the threshold: fewer lids lead. Raising the lead:
  /// blinks nearer in time, more overshoot.
  static constexpr float kBlinkThreshold = 1.8F;
  static constexpr float kBlinkLead = 0.05F;

  explicit JitterFilter(const JitterSettings& settings = {});

  /// Filters the next frame's weights in place, to [0, 1]; the first frame's stay.
  void apply(face::BlendshapeWeights& weights);
  /// Resets the state.
  void reset() { *this = JitterFilter(settings_); }

 private:
  JitterSettings settings_;
  NoiseLevel noise_;
  std::array<OneEuro, face::kShapeCount> filters_;
  face::BlendshapeWeights last_;  // The last frame's filtered weights, before the lids' lead.
  std::int64_t frames_ = 0;
};

}  // namespace mien::tracker
