#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "mien/synthetic/imu/make_dataset.h"

namespace mien::lab {

/// Which network a study trains, all of about as many parameters (0.2 to 0.4 million with eleven sensors).
enum class ShortNetwork : std::uint8_t {
  recurrent,    ///< The live model's kind: two layers of gated recurrent units, 128 wide, frame by frame.
  transformer,  ///< Two layers over a window of 120 frames, which answers at once: no diffusion.
  diffusion,    ///< The same, trained as a denoiser at all noise levels, as CAPUS is; asked in four steps.
};

/// A short training's recipe, but for its data.
struct ShortRecipe {
  std::uint64_t seed = 1;   ///< Of weights, order, augmentation and noise.
  std::size_t steps = 600;  ///< Optimisation steps; each sees 3,840 frames, whatever the window.
  ShortNetwork network = ShortNetwork::recurrent;
  std::size_t window = 120;  ///< Frames that are trained together: a divisor of 3,840.
  /// Recurrent networks' alone: weight of the squared error of changes from frame to frame in the loss.
  /// Higher: smoother, and slower to follow. 0: of the frames alone, as the others are trained.
  double difference_weight = 5;
};

/// A seed as recipes take it: TOML's integers are signed, of 64 bits. So the highest bit is left out; seeds
/// below 2^63 stay as they are.
[[nodiscard]] std::uint64_t recipe_seed(std::uint64_t seed);

/// ShortRecipe::seed of one of a study's trainings, from 0 on: recipe_seed(100 study_seed + training), the
/// sum modulo 2^64. Studies of neighbouring seeds share none while each has at most 100 trainings.
[[nodiscard]] std::uint64_t training_seed(std::uint64_t study_seed, std::size_t training);

/// As TOML, with what the data are.
[[nodiscard]] std::string short_recipe(const ShortRecipe& recipe, const synthetic::DataRecipe& data);

/// Whom short trainings learn from: 300 virtual people for 24 s each in *lab*, and two in five of them in
/// *device* too, as unlike the standard skin as those of the shipped models.
[[nodiscard]] synthetic::DataRecipe short_data(std::uint64_t seed);

/// The `[data]` table of a recipe, without its head.
[[nodiscard]] std::string data_table(const synthetic::DataRecipe& data);

}  // namespace mien::lab
