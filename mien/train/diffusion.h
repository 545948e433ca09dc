#pragma once

#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/train/batches.h"
#include "mien/train/network.h"

namespace mien::train {

/// A batch on the device that computes.
struct DeviceBatch {
  torch::Tensor condition, clean;  ///< [windows, frames, numbers].
  torch::Tensor level, held;       ///< [windows].
};

[[nodiscard]] DeviceBatch to_device(const Batch& batch, const Recipe& recipe, const torch::Device& device);

/// The forward process: mixes noise into clean windows at their levels, held first frames aside.
class NoiseMixer {
 public:
  NoiseMixer(const model::ScheduleSettings& schedule, const torch::Device& device);
  /// All shapes as DeviceBatch; `noise` as `clean`.
  [[nodiscard]] torch::Tensor mix(const DeviceBatch& batch, const torch::Tensor& noise) const;

 private:
  torch::Tensor keep_, add_;  ///< One number a level.
};

/// What a network that is not a window's says of a batch: predict_at_once(), added to what the recipe has it
/// added to.
[[nodiscard]] torch::Tensor answer_at_once(const Recipe& recipe, const Parameters& parameters,
                                           const torch::Tensor& condition, const Pass& pass);

/// Predicted less clean windows. What nobody can know of a window is no number there, and differs by nothing.
[[nodiscard]] torch::Tensor difference_of(const torch::Tensor& predicted, const torch::Tensor& clean);

/// The training loss: mean error of the clean windows, weighted by noise level where the recipe says so; of a
/// causal network's with that of the changes from frame to frame, and of its judgements of itself, where the
/// recipe says so.
[[nodiscard]] torch::Tensor loss_of(const Recipe& recipe, const torch::Tensor& predicted,
                                    const DeviceBatch& batch);

/// How well weights predict performers that they were not trained on.
struct ValidationScore {
  double loss = 0;  ///< Mean absolute error in [-1, 1]; a window network's over a few noise levels.
  double mse = 0;   ///< Squared error of weights in [0, 1]; a window network is asked once from pure noise.

  [[nodiscard]] double by(Score score) const { return score == Score::mse ? mse : loss; }
};

/// Scores weights on fixed windows with fixed noise: the same weights give the same score.
[[nodiscard]] ValidationScore validate(const Recipe& recipe, const Parameters& parameters,
                                       const Batch& windows, const NoiseMixer& mixer,
                                       const torch::Device& device);

/// The scores of parts, and what they are together by their shares.
struct PartScores {
  ValidationScore whole;
  std::vector<ValidationScore> parts;
};
[[nodiscard]] PartScores validate_parts(const Recipe& recipe, const Parameters& parameters,
                                        std::span<const ValidationPart> parts, const NoiseMixer& mixer,
                                        const torch::Device& device);

}  // namespace mien::train
