#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/headset/neutral_face.h"

// What was accepted as a headset's calibration is written and read back as it was.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto neutral = mien::headset::parse_neutral_face(text, "fuzz");
  if (!neutral) return 0;
  const auto back = mien::headset::parse_neutral_face(mien::headset::write_neutral_face(*neutral), "fuzz");
  if (!back || *back != *neutral) std::abort();
  return 0;
}
