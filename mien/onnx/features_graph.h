#pragma once

#include <string>
#include <vector>

#include "mien/model/features.h"
#include "mien/onnx/graph.h"

namespace mien::onnx {

/// Adds the way from what sensors say to the condition, as model::encode_features goes: inputs `features`,
/// 7n numbers a frame, and `present`, 2n. `rows`: the axes before these. Returns the condition's name.
std::string add_features(Graph& graph, const model::FeatureLayout& layout,
                         const model::FeatureNormalisation& normalisation, const std::vector<Axis>& rows);

/// The layout and the normalisation as JSON, for the file's metadata.
[[nodiscard]] std::string describe_features(const model::FeatureLayout& layout,
                                            const model::FeatureNormalisation& normalisation);

}  // namespace mien::onnx
