#pragma once

#include <cstdint>
#include <vector>

#include "mien/model/architecture.h"
#include "mien/train/network.h"

namespace mien::train {

/// Adam (Kingma and Ba 2015) with beta 0.9 and 0.999, over parameters whose gradients stand in them. Ours, so
/// that its state is plain tensors that a checkpoint holds to the bit.
///
/// Of those that are named as such, Muon instead (Jordan et al. 2024,
/// https://kellerjordan.github.io/posts/muon): the momentum, 0.95, of a parameter as a matrix of outputs x
/// inputs, all of its singular values brought to about 1, and so long that its numbers are as large as Adam's
/// (Liu et al. 2025, arXiv:2502.16982). One rate serves both.
class Adam {
 public:
  /// `orthogonal`: of each parameter, that it is stepped by Muon; empty: none.
  explicit Adam(const Parameters& parameters, std::vector<bool> orthogonal = {});

  /// One step with the gradients as they are; they are cleared. `clip_norm` > 0 shortens longer gradients
  /// first.
  void step(Parameters& parameters, double learning_rate, double clip_norm);

  Parameters mean, square;  ///< Moments, as the parameters; `mean` is Muon's momentum, `square` then unused.
  std::int64_t steps = 0;

 private:
  std::vector<bool> orthogonal_;
};

/// Which of an architecture's parameters Muon may step: the backbones' of a network of views, weights of
/// convolutions and of what follows them.
[[nodiscard]] std::vector<bool> matrices_of_backbones(const model::Architecture& architecture);

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
