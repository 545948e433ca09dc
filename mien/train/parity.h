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

}  // namespace mien::train
