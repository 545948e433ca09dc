#pragma once

#include <cmath>
#include <vector>

#include "mien/core/random.h"
#include "mien/model/backbone.h"

namespace mien::model {

/// Weights as a fresh training run has them: numbers keep their size from layer to layer.
inline std::vector<Tensor> random_backbone(const BackboneShape& shape, std::uint64_t seed) {
  Random random(seed);
  std::vector<Tensor> tensors;
  for (const TensorSpec& spec : tensor_specs(shape)) {
    Tensor& tensor = tensors.emplace_back(Tensor{.name = spec.name, .shape = spec.shape, .values = {}});
    std::size_t count = 1, inputs = 1;
    for (const std::size_t n : spec.shape) count *= n;
    for (std::size_t i = 1; i < spec.shape.size(); ++i) inputs *= spec.shape[i];
    const double spread = spec.shape.size() > 1 ? std::sqrt(2.0 / static_cast<double>(inputs)) : 0.05;
    for (std::size_t i = 0; i < count; ++i)
      tensor.values.push_back(static_cast<float>(spread * random.normal()));
  }
  return tensors;
}

}  // namespace mien::model
