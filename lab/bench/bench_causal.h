#pragma once

#include <string>

#include "mien/core/error.h"
#include "mien/model/precision.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::lab {

/// What `mien bench causal` is asked.
struct CausalBench {
  std::string model;  ///< Empty: the default live model.
  std::string precision{model::precision_name(tracker::kLivePrecision)};
  int frames = 3600;
  bool no_peers = false;  ///< ONNX Runtime and libtorch are not run.
  bool json = false;
};

/// Measures the live model's frame as a session lives it, its step in a hot loop, and how many performers one
/// core carries; beside what the core can do at most, measured in the same run. Prints it. Errors: the model
/// reader's and the tracker's; cancelled.
[[nodiscard]] Result<void> run_causal_bench(const CausalBench& options);

}  // namespace mien::lab
