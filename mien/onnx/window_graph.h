#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"
#include "mien/onnx/graph.h"

namespace mien::onnx {

/// Adds a window network with everything but its condition: inputs `noisy` [batch x frames x outputs] and
/// `level` [batch], output `clean`, like `noisy`. `condition` names [batch x frames x condition] numbers;
/// frames: 1 to architecture.window. `levels`: of the schedule, whose sinusoids stand in the file.
/// `network`: checked tensors, in network_tensors()'s order.
void add_window_network(Graph& graph, const model::Architecture& architecture,
                        std::span<const model::Tensor> network, const std::string& condition,
                        std::size_t levels);

}  // namespace mien::onnx
