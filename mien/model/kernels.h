#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

/// The operations between linear layers (linear.h), in SIMD chosen at run time by the CPU
/// (Highway). All buffers: fp32, row-major, 64-byte aligned with row strides of whole 64 bytes. No
/// allocation, thread-safe. One build on one CPU family gives the same bits each time; kernel_name() tells
/// which variant ran.
namespace mien::model {

/// Columns of a matrix are handled this many at a time.
inline constexpr std::size_t kPanel = 32;

/// `n` rounded up to whole panels.
[[nodiscard]] constexpr std::size_t padded(std::size_t n) {
  return (n + kPanel - 1) / kPanel * kPanel;
}

/// How far apart rows of `n` numbers stand best: a cache line more than whole panels, since rows at a power
/// of two from each other would fight for one place in the cache.
[[nodiscard]] constexpr std::size_t row_stride(std::size_t n) {
  return padded(n) + 16;
}

/// Each row becomes softmax(scale * row) over its first `columns` numbers; the rest of its padded width
/// becomes 0.
void softmax_rows(std::size_t rows, std::size_t columns, float scale, float* x, std::size_t stride);

/// Each row becomes (row - mean) / sqrt(variance + kLayerNormEpsilon) * gain + shift; `columns` a multiple of
/// kPanel.
void normalise_rows(std::size_t rows, std::size_t columns, const float* gain, const float* shift, float* x,
                    std::size_t stride);

/// One step of a gated recurrent unit: for each of `width` numbers (a multiple of kPanel), with `from_input`
/// and `from_state` holding three parts of that width (reset, update, new), biases included:
/// r = sigmoid(i_r + s_r), z = sigmoid(i_z + s_z), n = tanh(i_n + r s_n), state = n + z (state - n).
void apply_gates(std::size_t width, const float* from_input, const float* from_state, float* state);

/// The variant that this CPU runs: "AVX3", "AVX2", "NEON" and so on.
[[nodiscard]] std::string_view kernel_name();

/// Names of all variants that this CPU can run, best first (while none is forced); and a way to run a given
/// one, for tests. An empty name goes back to the best. Not thread-safe against running kernels.
[[nodiscard]] std::vector<std::string_view> available_kernels();
void force_kernel(std::string_view name);

}  // namespace mien::model
