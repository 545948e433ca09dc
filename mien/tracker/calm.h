#pragma once

#include <array>
#include <cstdint>

#include "mien/core/one_euro.h"
#include "mien/face/profile.h"

namespace mien::tracker {

/// Takes the trembling out of what a causal network answers, which follows its sensors' noise: a One Euro
/// filter a shape, on frames a 60th of a second apart. One performance's. No allocation.
class Calm {
 public:
  /// On virtual performers in *lab*, whose rotations carry a degree of white noise, this takes the third
  /// difference from 6 times the truth's to 1.0, for 2 % of squared error (docs/live_model.md). The delay at
  /// rest is a tenth of a second; a lid that closes in a tenth of a second is 12 ms late, one that opens 25
  /// ms.
  static constexpr OneEuroSettings kSettings{.min_cutoff_hz = 1.5, .beta = 3};

  Calm() { filters_.fill(OneEuro(kSettings)); }

  /// The next frame's weights; the first frame's stay as they are.
  void apply(face::BlendshapeWeights& weights);
  /// Forgets the performance.
  void reset() { *this = {}; }

 private:
  std::array<OneEuro, face::kShapeCount> filters_;
  std::int64_t frames_ = 0;
};

}  // namespace mien::tracker
