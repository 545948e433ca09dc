#include "app/bench_peers.h"

#include "app/onnx_peer.h"

namespace mien::app {

Peer onnxruntime_step(const std::filesystem::path& model) {
  const auto times = measure_onnxruntime({.model = model});
  if (!times) return {.step_us = std::nullopt, .why_not = times.error().message()};
  return {.step_us = 1e6 * times->best_step_s, .why_not = {}};
}

Peer libtorch_step(const std::filesystem::path&) {
  return {.step_us = std::nullopt, .why_not = "this version does not run libtorch's step yet"};
}

}  // namespace mien::app
