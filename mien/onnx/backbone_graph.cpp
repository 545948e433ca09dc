#include "mien/onnx/backbone_graph.h"

#include <cstdint>
#include <vector>

namespace mien::onnx {

void add_backbone(Graph& graph, const model::BackboneShape& shape, std::span<const model::Tensor> tensors,
                  const std::string& pictures) {
  using Integers = std::vector<std::int64_t>;
  for (const model::Tensor& tensor : tensors) graph.constant(tensor.name, tensor.shape, tensor.values);
  std::string x = pictures;
  for (std::size_t i = 0; i < shape.widths.size(); ++i) {
    const std::string sum = graph.add(
        "Conv", {x, tensors[2 * i].name, tensors[2 * i + 1].name},
        {{"kernel_shape", Integers{3, 3}}, {"strides", Integers{2, 2}}, {"pads", Integers{1, 1, 1, 1}}});
    x = graph.add("Relu", {sum});
  }
  x = graph.add("Flatten", {x}, {{"axis", std::int64_t{1}}});
  graph.gemm(x, tensors[tensors.size() - 2].name, tensors.back().name, "features");
  graph.output({.name = "features",
                .shape = {"batch", shape.features},
                .says = "What the picture shows, in the network's own terms."});
}

}  // namespace mien::onnx
