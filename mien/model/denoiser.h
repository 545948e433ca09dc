#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/linear.h"
#include "mien/model/model_file.h"

namespace mien::model {

/// The network at run time: a noisy window and its condition in, the clean window out. One thread.
/// Immutable, so any number of threads may share one; each needs a Workspace of its own.
/// In fp32 it agrees with libtorch to 1e-4 on one call (`mien-train parity`); attention is fp32 in every
/// precision.
class Denoiser {
 public:
  /// Lays the weights out for the kernels (about 10 ms for the light network). Errors: mismatch,
  /// out_of_range.
  [[nodiscard]] static Result<Denoiser> create(const Architecture& architecture,
                                               std::span<const Tensor> network,
                                               Precision precision = Precision::fp32);

  /// Memory that calls work in, for one thread. Reused, it makes them free of allocation.
  class Workspace {
   public:
    explicit Workspace(const Denoiser& denoiser);

   private:
    friend class Denoiser;
    std::size_t frames_ = 0;
    // Rows are row_stride() apart.
    AlignedFloats
        conditioned_;       ///< window x d_model: the condition's part of the input layer, and the positions.
    AlignedFloats tokens_;  ///< (window + 1) x d_model.
    AlignedFloats queries_;      ///< (window + 1) x d_attention.
    AlignedFloats keys_values_;  ///< (window + 1) x 2 d_attention.
    AlignedFloats head_keys_;    ///< d_head x (window + 1): one head's keys, transposed.
    AlignedFloats scores_;       ///< (window + 1) x (window + 1).
    AlignedFloats attended_;     ///< (window + 1) x d_attention.
    AlignedFloats hidden_;       ///< (window + 1) x ffn.
    AlignedFloats answer_;       ///< window x outputs.
    Aligned<double> noise_;      ///< d_model: the noise token's sums.
    ConvertedRows converted_;
  };

  /// Fixes the window's condition for the predictions that follow: [frames x condition], 1 to `window`
  /// frames.
  void set_condition(std::span<const float> condition, Workspace& workspace) const;

  /// The clean window that the network sees in a noisy one. `noisy` and `clean`: [frames x outputs] of the
  /// same frames as the condition, nominally in [-1, 1]; `level`: 0 to levels - 1. No allocation. The same
  /// object may be both.
  void predict(std::span<const float> noisy, std::size_t level, std::span<float> clean,
               Workspace& workspace) const;

  [[nodiscard]] const Architecture& architecture() const { return architecture_; }

 private:
  struct Layer {
    PackedLinear query, keys_values, attended;
    AlignedFloats attention_gain, attention_shift;
    PackedLinear ffn_hidden, ffn_out;
    AlignedFloats ffn_gain, ffn_shift;
  };

  Denoiser() = default;
  void write_noise_token(std::size_t level, Workspace& workspace) const;
  // All layers work on tokens [first, end) alone, but for keys and values, which are all tokens'.
  void attend(const Layer& layer, std::size_t first, Workspace& workspace) const;
  void run(const Layer& layer, std::size_t first, Workspace& workspace) const;

  Architecture architecture_;
  PackedLinear noisy_input_, condition_input_;  ///< The input layer's two parts; the second carries the bias.
  // The noise token's two layers, transposed: [in, out].
  std::vector<float> noise_hidden_weight_, noise_hidden_bias_, noise_out_weight_, noise_out_bias_;
  AlignedFloats positions_;  ///< (window + 1) x d_model.
  std::vector<Layer> layers_;
  PackedLinear output_;
};

}  // namespace mien::model
