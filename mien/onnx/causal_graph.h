#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"
#include "mien/onnx/graph.h"

namespace mien::onnx {

/// What a causal network's numbers y are turned into: factor * y + shift.
struct CausalAnswer {
  std::string name;  ///< Of the output, and what it says.
  std::string says;
  float factor = 1, shift = 0;
  bool held = false;  ///< Then held to [0, 1].
};

/// Adds a causal network, `steps` frames of it one after the other, with everything but its first input:
/// inputs state_K, [batch x d_model] a layer; outputs the answer and next_state_K. `condition` names
/// [batch x condition] numbers, or, of several steps, [steps * batch x condition], a step's rows together;
/// the answer's rows stand so too. `network`: checked tensors, in network_tensors()'s order.
void add_causal_network(Graph& graph, const model::Architecture& architecture,
                        std::span<const model::Tensor> network, const std::string& condition,
                        const CausalAnswer& answer, std::size_t steps);

}  // namespace mien::onnx
