#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/headset/wearer_calibration.h"

// What was accepted as a headset's calibration is written and read back as it was.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto calibration = mien::headset::parse_wearer_calibration(text, "fuzz");
  if (!calibration) return 0;
  const auto back =
      mien::headset::parse_wearer_calibration(mien::headset::write_wearer_calibration(*calibration), "fuzz");
  if (!back || *back != *calibration) std::abort();
  return 0;
}
