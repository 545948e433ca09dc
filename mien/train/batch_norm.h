#pragma once

#include "mien/train/torch.h"

namespace mien::train {

/// Added to a channel's variance, so that an even one can be normalised.
inline constexpr double kBatchNormEpsilon = 1e-5;

/// What batch normalisation found of one convolution, fp32, a value a channel.
struct ChannelStatistics {
  torch::Tensor mean, variance;
};

/// Batch normalisation (Ioffe and Szegedy 2015, arXiv:1502.03167) with a shift and no gain, and a ReLU behind
/// it, differentiable. `x`: [n, channels, height, width]; `shift`: [channels], of the same type.
/// `statistics`: where each channel's mean and variance go; may be null. In fp32 on a CPU both are one
/// pass of our own over the memory, since a training's first layers are bound by it; the same bits on any
/// number of threads there.
[[nodiscard]] torch::Tensor normalise_and_rectify(const torch::Tensor& x, const torch::Tensor& shift,
                                                  ChannelStatistics* statistics);

}  // namespace mien::train
