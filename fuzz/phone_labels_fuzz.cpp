#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "lab/speech/phone_labels.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto closures = mien::lab::parse_phone_labels({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!closures) return 0;
  // What was accepted is in order, and within an hour.
  double last_s = 0;
  for (const mien::synthetic::Closure& closure : *closures) {
    if (!(closure.begin_s >= last_s && closure.end_s >= closure.begin_s && closure.end_s <= 3600))
      std::abort();
    last_s = closure.begin_s;
  }
  return 0;
}
