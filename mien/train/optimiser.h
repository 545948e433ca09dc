#pragma once

#include <cstdint>

#include "mien/train/network.h"

namespace mien::train {

/// Adam (Kingma and Ba 2015) with beta 0.9 and 0.999, over parameters whose gradients stand in them. Ours, so
/// that its state is plain tensors that a checkpoint holds to the bit.
class Adam {
 public:
  explicit Adam(const Parameters& parameters);

  /// One step with the gradients as they are; they are cleared. `clip_norm` > 0 shortens longer gradients
  /// first.
  void step(Parameters& parameters, double learning_rate, double clip_norm);

  Parameters mean, square;  ///< Moments, as the parameters.
  std::int64_t steps = 0;
};

/// Weights averaged over training, which predict better than the last ones.
class MovingAverage {
 public:
  explicit MovingAverage(const Parameters& parameters);
  /// average += (1 - keep) * (parameters - average); early on it keeps less, so that the beginning is
  /// forgotten.
  void add(const Parameters& parameters, double keep);

  Parameters average;
  std::int64_t count = 0;
};

}  // namespace mien::train
