#pragma once

#include <cstddef>
#include <vector>

namespace mien::model {

/// What is added to a causal network's answers for one wearer: a linear residual, fitted to somebody else's
/// measure of the same face (tracker::learn_correction). With the answers a of this frame and of earlier
/// ones, side by side in the order of `lags`, the answer becomes a + W a. Nothing is added to an answer of
/// zeros, so a face at rest stays at rest.
struct Correction {
  /// Frames back, ascending, the first 0; at most kMostCorrectionLags of them, kLongestCorrectionLag at most.
  std::vector<std::size_t> lags;
  /// W, shapes x (lags * shapes), row-major; each within kMostCorrection either way. A row of zeros leaves
  /// its shape.
  std::vector<float> weights;
  bool operator==(const Correction&) const = default;
};

inline constexpr std::size_t kMostCorrectionLags = 8;
inline constexpr std::size_t kLongestCorrectionLag = 60;
inline constexpr float kMostCorrection = 100;

}  // namespace mien::model
