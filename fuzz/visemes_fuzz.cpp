#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/speech/visemes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto visemes = mien::speech::Visemes::parse({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!visemes) return 0;
  // What was accepted is within its ranges.
  const auto is_share = [](float value) { return value >= 0 && value <= 1; };
  for (std::size_t v = 0; v < mien::speech::kVisemeCount; ++v) {
    const mien::speech::Viseme& viseme = (*visemes)[v];
    if (!std::ranges::all_of(viseme.weights, is_share) || !is_share(viseme.tongue) || !is_share(viseme.jaw) ||
        !is_share(viseme.lips) || !(viseme.onset_s > 0) || !(viseme.release_s > 0))
      std::abort();
  }
  return 0;
}
