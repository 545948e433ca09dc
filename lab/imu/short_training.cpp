#include "lab/imu/short_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mien/core/units.h"

namespace mien::lab {
namespace {

/// Frames that a step sees.
constexpr std::size_t kFramesAStep = 3840;

std::string network_table(const ShortRecipe& recipe) {
  if (recipe.network == ShortNetwork::recurrent)
    return fmt::format("architecture = \"causal\"\nd_model = 128\nwindow = {}\ndropout = 0\n", recipe.window);
  return fmt::format(
      "architecture = \"light\"\nlayers = 2\nd_model = 128\nheads = 4\nd_head = 32\nffn = 256\nwindow = {}\n"
      "dropout = 0\nnear_first = true\n",
      recipe.window);
}

std::string network_settings(const ShortRecipe& recipe) {
  switch (recipe.network) {
    case ShortNetwork::recurrent:
      return "";
    case ShortNetwork::transformer:
      // Levels are drawn so near the noisiest that what it reads of the answer says nothing.
      return "\n[noise]\nt_bias = 100\n\n[sampler]\nsteps = [1]\nframes = 1200\n";
    case ShortNetwork::diffusion:
      return "\n[noise]\nheld_overlap = 0.25\n\n[sampler]\nsteps = [4]\nframes = 1200\n";
  }
  return "";
}

}  // namespace

std::uint64_t recipe_seed(std::uint64_t seed) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::int64_t>::max();
  return seed & kLargest;
}

std::uint64_t training_seed(std::uint64_t study_seed, std::size_t training) {
  return recipe_seed(study_seed * 100 + training);
}

std::string data_table(const synthetic::DataRecipe& data) {
  return fmt::format(
      "seed = {}\nperformers = {}\nvalidation_performers = {}\nseconds = {}\ndevice_seconds = {}\n"
      "device_share = {}\nidentities = {}\nplacement_mm = {}\nkinematics_gain = {}\nkinematics_deg = {:g}\n",
      data.seed, data.performers, data.validation_performers, data.seconds, data.device_seconds,
      data.device_share, data.identities, data.placement_mm, data.kinematics.gain,
      data.kinematics.direction_rad * kDegPerRad);
}

std::string short_recipe(const ShortRecipe& recipe, const synthetic::DataRecipe& data) {
  const bool recurrent = recipe.network == ShortNetwork::recurrent;
  return fmt::format(
      "seed = {}\n\n[network]\n{}\n[data]\n{}\n[optimiser]\nlearning_rate = {}\nloss = \"l2\"\nbatch = {}\n"
      "warm_up_steps = {}\nema = 0.98\n{}\n[augmentation]\nsensor_loss = 0.02\nmany_lost = 0.02\n{}\n"
      "[validation]\nwindows = 200\nevery_steps = {}\n\n[budget]\nsteps = {}\n",
      recipe.seed, network_table(recipe), data_table(data), recurrent ? "4e-3" : "2e-3",
      kFramesAStep / recipe.window, std::min<std::size_t>(40, recipe.steps / 4),
      recurrent ? fmt::format("difference_weight = {}\n", recipe.difference_weight) : "",
      network_settings(recipe), std::max<std::size_t>(1, recipe.steps / 6), recipe.steps);
}

synthetic::DataRecipe short_data(std::uint64_t seed) {
  synthetic::DataRecipe data;
  data.seed = seed;
  data.performers = 300;
  data.validation_performers = 8;
  data.seconds = 24;
  data.device_seconds = 24;
  data.device_share = 0.4;
  data.kinematics = {.gain = 0.30, .direction_rad = 13 * kRadPerDeg};
  return data;
}

}  // namespace mien::lab
