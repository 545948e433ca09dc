#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/core/wav.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto sound = mien::parse_wav(std::as_bytes(std::span(data, size)), "fuzz");
  // What was read can be written and read again.
  if (sound && mien::parse_wav(mien::format_wav(*sound), "again")->samples.size() != sound->samples.size())
    std::abort();
  return 0;
}
