#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/eyewear/marker_network.h"
#include "mien/headset/views_file.h"
#include "mien/model/backbone.h"
#include "mien/model/model_file.h"

namespace mien::onnx {

/// Most frames that a graph may chain.
inline constexpr std::size_t kMostSteps = 256;

/// What is to be exported of a model file, and how.
struct ExportRequest {
  /// Or "ridge.PROFILE", as the file's tensors are called; of a headset's model "eye", "mouth" or "moment".
  std::string part = "network";
  /// The graph takes what sensors say (m/s^2, quaternions, flags) instead of the normalised condition.
  bool features = false;
  /// Frames that one run of a causal network answers, its states passed on within the graph; 1 to kMostSteps.
  std::size_t steps = 1;
};

/// An ONNX file's bytes: opset 17, plain operators, fp32, weights inside. Every input, output and the
/// metadata are described in the file; docs/guide/onnx.md lists them. The same model gives the same bytes.
/// Errors: not_found (no such part), bad_usage (several steps of what has no state, features that the file
/// does not know), out_of_range (steps), mismatch (a model that does not hold together).
[[nodiscard]] Result<std::vector<std::byte>> onnx_of(const model::ModelFile& model,
                                                     const ExportRequest& request = {});
/// The eyewear model's: its answer is in metres.
[[nodiscard]] Result<std::vector<std::byte>> onnx_of(const eyewear::MarkerNetworkFile& model,
                                                     const ExportRequest& request = {});
/// A headset's: "eye" and "mouth" find what is in pictures, "moment" answers it, and "network" is the memory,
/// from moment_condition() numbers to what is added to that answer.
/// Errors: also not_found (a model without a memory).
[[nodiscard]] Result<std::vector<std::byte>> onnx_of(const headset::ViewsFile& model,
                                                     const ExportRequest& request = {});
/// A network of pictures alone: "pictures" [batch x 1 x size x size] to "features" [batch x features].
/// `tensors` in tensor_specs()'s order. Errors: out_of_range, mismatch.
[[nodiscard]] Result<std::vector<std::byte>> onnx_of(const model::BackboneShape& shape,
                                                     std::span<const model::Tensor> tensors);
/// Of a model file of any format. Errors: also the readers'.
[[nodiscard]] Result<std::vector<std::byte>> onnx_of_file(const std::filesystem::path& path,
                                                          const ExportRequest& request = {});

/// An ONNX file with the inputs of another, which it gives back untouched: what running a graph costs that
/// does nothing. Errors: malformed.
[[nodiscard]] Result<std::vector<std::byte>> echo_of(std::span<const std::byte> onnx);

}  // namespace mien::onnx
