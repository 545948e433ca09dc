#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/architecture.h"
#include "mien/model/safetensors.h"

namespace mien::train {

/// Everything that a training run knows beyond its recipe and its data. Each step's randomness follows from
/// the recipe's seed and the step's number, so no generator's state is among it.
struct Checkpoint {
  std::string run;        ///< Hash of recipe, data and device: what it may be resumed with.
  std::int64_t step = 0;  ///< Steps done.
  std::int64_t averagings = 0;
  double seconds = 0;  ///< Spent in steps.
  double best_score = std::numeric_limits<double>::max();
  std::int64_t best_step = 0;
  std::string curve;        ///< The loss curve's CSV rows so far.
  double loss_sum = 0;      ///< Of the steps since its last row, ...
  std::int64_t losses = 0;  ///< ... and how many they are.
  /// As model::network_tensors() lists them.
  std::vector<model::Tensor> weights, adam_mean, adam_square, average, best;
};

/// Writes the file whole or not at all. Errors: io.
[[nodiscard]] Result<void> write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// Errors: not_found, truncated, malformed, mismatch (another architecture).
[[nodiscard]] Result<Checkpoint> read_checkpoint(const std::filesystem::path& path,
                                                 const model::Architecture& architecture);

}  // namespace mien::train
