#pragma once

#include <cstddef>

/// What one core can do at most, measured: a benchmark's figures mean something only beside these, from the
/// same run. The best of many short tries, so that a neighbour's work hardly shows. In the variant that
/// model::kernel_name() names.
namespace mien::lab {

/// fp32 multiplications and additions in a second, fused and all in registers, in units of 1e9 (one fused is
/// two). About 20 ms.
[[nodiscard]] double peak_gflops();

/// Bytes read in a second, in units of 1e9, from `bytes` that were read before: 8 MB tells the third cache of
/// most CPUs. About 20 ms for these.
[[nodiscard]] double read_gb_s(std::size_t bytes);

}  // namespace mien::lab
