#include "app/bench_peers.h"

namespace mien::app {

Peer measure_onnxruntime(const std::filesystem::path&) {
  return {.step_us = std::nullopt, .why_not = "this version does not run ONNX Runtime yet"};
}

Peer measure_libtorch(const std::filesystem::path&) {
  return {.step_us = std::nullopt, .why_not = "this version does not run libtorch's step yet"};
}

}  // namespace mien::app
