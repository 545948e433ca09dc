#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/synthetic/imu/make_dataset.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto recipe = mien::synthetic::parse_data_recipe(
      std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!recipe) return 0;
  // What was accepted asks for something that can be made.
  const auto size_within = [](double value, double most) { return value >= 0 && value <= most; };
  if (recipe->performers < 1 || recipe->validation_performers < 1 || !size_within(recipe->seconds, 86'400) ||
      !size_within(recipe->device_seconds, 86'400) || !size_within(recipe->device_share, 1) ||
      !size_within(recipe->placement_mm, 50) || !size_within(recipe->kinematics.gain, 10) ||
      !size_within(recipe->kinematics.direction_rad, 3.15) || recipe->seconds + recipe->device_seconds <= 0)
    std::abort();
  return 0;
}
