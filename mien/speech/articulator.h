#pragma once

#include <span>

#include "mien/face/profile.h"
#include "mien/speech/visemes.h"

namespace mien::speech {

/// A speech sound and when it is said: seconds on the sound's own clock, end_s >= begin_s.
struct TimedSound {
  VisemeParts parts;
  double begin_s = 0, end_s = 0;
};

/// What a mouth does at one moment.
struct Mouth {
  face::BlendshapeWeights weights;  ///< Shapes of mouth and jaw; the others 0.
  float tongue = 0;                 ///< Tongue out, 0 to 1.
  float closure = 0;                ///< 0 to 1: at 1 the lips meet, and mouthClose is jawOpen.
};

/// Brings the lips together by so much, 0 to 1: mouthClose is that share of jawOpen, and what parts them is
/// taken back.
void close_lips(float closure, face::BlendshapeWeights& weights);

/// From sounds to the mouth with coarticulation: at every moment the visemes about it pull at jaw and lips,
/// each with the dominance of its class (Cohen and Massaro 1993), and rest pulls a little, so that silence
/// closes the mouth. A diphthong is its two parts in turn. A sound that closes the lips does so whatever its
/// neighbours want: from its beginning, or half of the sound before, 40 to 120 ms, ahead of its burst where
/// that is earlier, until the burst, the last quarter of it. No state: what is asked of moments before the
/// newest sounds changes as these become known. No allocation. Thread-safe.
class Articulator {
 public:
  explicit Articulator(const Visemes& visemes = Visemes::standard()) : visemes_(&visemes) {}

  /// `sounds`: in order; those that are half a second away have no influence.
  [[nodiscard]] Mouth at(double time_s, std::span<const TimedSound> sounds) const;

 private:
  const Visemes* visemes_;  // As long-lived as this.
};

}  // namespace mien::speech
