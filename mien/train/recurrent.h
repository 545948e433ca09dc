#pragma once

#include "mien/train/torch.h"

namespace mien::train {

/// A layer of gated recurrent units over whole sequences, from states of zero, differentiable; what
/// model::apply_gates does frame by frame. `from_input` [frames, sequences, 3 width]: the input's part of
/// reset, update and new, bias included; `weight` [3 width, width] and `bias` [3 width]: the state's part.
/// Result: the states, [frames, sequences, width]. All fp32; with `bf16` the weight's gradient, one large
/// product, is computed in bf16. Its backward pass is written out because libtorch's own, an operation at a
/// time, takes several times as long on a CPU.
[[nodiscard]] torch::Tensor run_recurrent(const torch::Tensor& from_input, const torch::Tensor& weight,
                                          const torch::Tensor& bias, bool bf16);

}  // namespace mien::train
