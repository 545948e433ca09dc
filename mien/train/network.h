#pragma once

#include <vector>

#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"
#include "mien/train/torch.h"

namespace mien::train {

/// The network's weights as libtorch tensors, in the order of model::network_tensors().
using Parameters = std::vector<torch::Tensor>;

/// Fresh weights: uniform in +-1/sqrt(inputs) as libtorch's own linear layers, normalisations the identity.
/// The same seed gives the same weights everywhere. With `near_first`, query and key of each head begin as
/// the same few quick position waves, so that a frame looks at its neighbours; else a network must first
/// learn where they are.
[[nodiscard]] Parameters fresh_parameters(const model::Architecture& architecture, std::uint64_t seed,
                                          bool near_first, const torch::Device& device);

/// To and from a model file's tensors. Sizes must be the architecture's.
[[nodiscard]] std::vector<model::Tensor> to_tensors(const model::Architecture& architecture,
                                                    const Parameters& parameters);
[[nodiscard]] Parameters from_tensors(const std::vector<model::Tensor>& tensors, const torch::Device& device);

/// How a pass through the network is computed.
struct Pass {
  double dropout =
      0;  ///< Share of activations dropped after softmax, attention and feed-forward; 0 when not training.
  bool bf16 = false;  ///< Products in bf16 with fp32 sums: more than twice as fast where the CPU has it.
  /// Of a network of pictures: batch normalisation (Ioffe and Szegedy 2015, arXiv:1502.03167) behind each
  /// convolution, whose bias is the shift; its gain is left to the next layer, since a ReLU passes it on.
  bool batch_norm = false;
};

/// What a network answers that is not a window's. Shapes: condition [sequences, frames, condition], result
/// [sequences, frames, outputs] in fp32. A causal one: the same function as model::CausalNetwork from a fresh
/// state on, frame by frame. One of pictures: the same function as model::ViewsNetwork, of wearers and their
/// moments, the first at rest, of model::views_condition() numbers.
[[nodiscard]] torch::Tensor predict_at_once(const model::Architecture& architecture,
                                            const Parameters& parameters, const torch::Tensor& condition,
                                            const Pass& pass);

/// Of a network of pictures that answers with Pass::batch_norm: the weights that answer the same without it,
/// on pictures whose channels have the means and variances that they have in `condition`.
[[nodiscard]] Parameters fold_batch_norm(const model::Architecture& architecture,
                                         const Parameters& parameters, const torch::Tensor& condition);

/// The clean windows that the network sees in noisy ones, differentiable: the same function as
/// model::Denoiser. Shapes: noisy [windows, frames, outputs], condition [windows, frames, condition], level
/// [windows] (whole numbers), result [windows, frames, outputs] in fp32.
[[nodiscard]] torch::Tensor predict(const model::Architecture& architecture, const Parameters& parameters,
                                    const torch::Tensor& noisy, const torch::Tensor& condition,
                                    const torch::Tensor& level, const Pass& pass);

}  // namespace mien::train
