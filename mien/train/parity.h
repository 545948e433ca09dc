#pragma once

#include <cstddef>

#include "mien/core/error.h"
#include "mien/model/model_file.h"

namespace mien::train {

/// How far the run time may be from libtorch: the largest absolute difference of one call.
inline constexpr double kParityLimit = 1e-4;

struct Parity {
  double largest_difference =
      0;  ///< Over all outputs of all calls (or frames), in the network's range of -1 to 1.
  std::size_t calls = 0;
};

/// Compares the run time with libtorch in fp32 on random input: model::Denoiser on windows, full and short,
/// at levels from first to last; model::CausalNetwork on whole sequences, frame by frame.
[[nodiscard]] Result<Parity> measure_parity(const model::ModelFile& model);

/// How long libtorch takes for one cached step of a causal network: a frame's condition and the states in,
/// weights and states out, without gradients, fp32.
struct LibtorchStep {
  double step_s = 0;              ///< The smallest of rounds' medians, as the run time's own is measured.
  double largest_difference = 0;  ///< Of its answers from the run time's, in the network's range of -1 to 1.
};

/// On one thread, of which it makes libtorch's only one. Errors: unsupported (no causal network), mismatch
/// (it answers otherwise than the run time by more than kParityLimit: then its time is worth nothing), the
/// network's.
[[nodiscard]] Result<LibtorchStep> measure_libtorch_step(const model::ModelFile& model);

}  // namespace mien::train
