#pragma once

#include <onnx/onnx_pb.h>

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tests/eyewear/small_marker_network.h"
#include "tests/model/random_network.h"

namespace mien::onnx::test {

/// A small window model whose heads are more than one and narrower than a token.
inline model::ModelFile window_model() {
  model::ModelFile model = model::small_model();
  model.architecture.layers = 2;
  model.architecture.heads = 2;
  model.architecture.ffn = 64;
  model.network = model::random_network(model.architecture, 3);
  return model;
}

inline model::ModelFile causal_model() {
  model::ModelFile model = model::small_causal_model();
  model.architecture.layers = 2;
  model.network = model::random_network(model.architecture, 4);
  return model;
}

inline ::onnx::ModelProto parsed(std::span<const std::byte> bytes) {
  ::onnx::ModelProto model;
  model.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
  return model;
}

inline std::map<std::string, std::string> metadata(const ::onnx::ModelProto& model) {
  std::map<std::string, std::string> texts;
  for (const auto& entry : model.metadata_props()) texts[entry.key()] = entry.value();
  return texts;
}

}  // namespace mien::onnx::test
