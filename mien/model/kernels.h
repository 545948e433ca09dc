#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

/// The few operations on which all of the networks' time goes, in SIMD chosen at run time by the CPU
/// (Highway). All buffers: fp32, row-major, 64-byte aligned with row strides a multiple of kPanel. No
/// allocation, thread-safe. One build on one CPU family gives the same bits each time; kernel_name() tells
/// which variant ran.
namespace mien::model {

/// Columns of a matrix are handled this many at a time.
inline constexpr std::size_t kPanel = 32;

/// `n` rounded up to whole panels.
[[nodiscard]] constexpr std::size_t padded(std::size_t n) {
  return (n + kPanel - 1) / kPanel * kPanel;
}

/// fp32 numbers, zero at first, at an address that suits the widest SIMD.
class AlignedFloats {
 public:
  AlignedFloats() = default;
  explicit AlignedFloats(std::size_t size);
  [[nodiscard]] float* data() { return values_.get(); }
  [[nodiscard]] const float* data() const { return values_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }
  float& operator[](std::size_t i) { return values_[i]; }
  float operator[](std::size_t i) const { return values_[i]; }

 private:
  struct Free {
    void operator()(float* p) const;
  };
  std::unique_ptr<float[], Free> values_;
  std::size_t size_ = 0;
};

/// A linear layer y = W x + b, laid out once so that each call reads its weights in order.
struct PackedLinear {
  std::size_t in = 0, out = 0;
  AlignedFloats weights;  ///< padded(out) / kPanel panels of in x kPanel.
  AlignedFloats bias;     ///< padded(out); zeros behind the end.
};

/// Packs columns [first, first + count) of the [out, total_in] matrix `weight`; an empty bias is zero.
[[nodiscard]] PackedLinear pack_linear(std::span<const float> weight, std::span<const float> bias,
                                       std::size_t out, std::size_t total_in, std::size_t first,
                                       std::size_t count);

enum class Activation { none, relu };

/// y[r] = activation(W x[r] + b + add[r]) for each of `rows` rows; `add` may be null, and may be y itself.
/// Strides are in numbers; y has padded(out) columns, of which those behind `out` become 0 (plus add).
void apply_linear(const PackedLinear& layer, std::size_t rows, const float* x, std::size_t x_stride,
                  const float* add, std::size_t add_stride, Activation activation, float* y,
                  std::size_t y_stride);

/// c = a b for a [rows x depth] and b [depth x padded columns]: attention's two products.
void multiply(std::size_t rows, std::size_t depth, std::size_t columns, const float* a, std::size_t a_stride,
              const float* b, std::size_t b_stride, float* c, std::size_t c_stride);

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
