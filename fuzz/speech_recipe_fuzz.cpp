#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/synthetic/speech/speech_dataset.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto recipe = mien::synthetic::parse_speech_data_recipe(
      std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!recipe) return 0;
  // What was accepted asks for something that can be made.
  if (recipe->passages < 1 || recipe->validation_passages < 1 || recipe->look_ahead > 1 ||
      !(recipe->other_seconds >= 5 && recipe->other_seconds <= 3600))
    std::abort();
  return 0;
}
