#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/synthetic/eyewear/eyewear_dataset.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto recipe = mien::synthetic::parse_eyewear_data_recipe(
      std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!recipe) return 0;
  // What was accepted asks for something that can be made.
  if (recipe->wearers < 1 || recipe->validation_wearers < 1 || !(recipe->seconds >= 12) ||
      !(recipe->seconds <= 3600))
    std::abort();
  return 0;
}
