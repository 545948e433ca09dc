#pragma once

#include <cstdint>

#include "mien/core/error.h"

namespace mien::lab {

/// What `mien bench headset` is asked.
struct HeadsetBench {
  int frames = 600;
  std::uint64_t seed = 1;  ///< Of the networks' weights and of the pictures.
  bool no_peers = false;   ///< ONNX Runtime is not run.
  bool json = false;
};

/// Measures what a headset's four views cost on their way through the networks of pictures, in each
/// precision: paced with cold caches and in a hot loop, beside ONNX Runtime and what the core can do at most,
/// in the same run. Prints it. Errors: cancelled.
[[nodiscard]] Result<void> run_headset_bench(const HeadsetBench& options);

}  // namespace mien::lab
