#pragma once

#include <span>
#include <string>

#include "mien/model/backbone.h"
#include "mien/onnx/graph.h"

namespace mien::onnx {

/// Adds a network of pictures with its output "features", [batch x features]. `pictures` names
/// [batch x 1 x size x size] numbers. `tensors`: checked, in tensor_specs()'s order.
void add_backbone(Graph& graph, const model::BackboneShape& shape, std::span<const model::Tensor> tensors,
                  const std::string& pictures);

}  // namespace mien::onnx
