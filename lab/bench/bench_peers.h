#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace mien::lab {

/// How fast somebody else's run time does the same cached step with the same weights, in fp32 on one thread.
struct Peer {
  std::optional<double> step_us;  ///< Of a step; nothing where the peer is not here.
  std::string why_not;            ///< Then the reason, for people.
};

/// ONNX Runtime, on the model exported to ONNX: the quickest rounds of its best graph
/// (lab/bench/onnx_peer.h).
[[nodiscard]] Peer onnxruntime_step(const std::filesystem::path& model);
/// libtorch, in the helper mien-train: its quickest rounds.
[[nodiscard]] Peer libtorch_step(const std::filesystem::path& model);

}  // namespace mien::lab
