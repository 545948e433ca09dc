#pragma once

#include <string>
#include <vector>

namespace mien::model {

/// What is added to the output layer of a causal network for one wearer, fitted to somebody else's measure of
/// the same face (tracker::learn_correction). With x the d_model numbers that the output layer reads, its
/// answer y = W x + b, nominally in [-1, 1], becomes y + C x + c.
struct Correction {
  std::string network;         ///< Of which network: correction_key(). It is nonsense to any other.
  std::vector<float> weights;  ///< C, outputs x d_model, row-major; each within kMostCorrection either way.
  std::vector<float> bias;     ///< c, one an output; likewise. Zeros in both leave a shape as it is.
  bool operator==(const Correction&) const = default;
};

/// Far beyond what is learnt: the output layer's own weights are below 1.
inline constexpr float kMostCorrection = 10;

}  // namespace mien::model
