#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/sensor/rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto rig =
      mien::sensor::parse_rig(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!rig) return 0;
  // What was accepted is written as a rig that reads and writes the same.
  const std::string text = mien::sensor::write_rig(*rig);
  const auto again = mien::sensor::parse_rig(text, "written");
  if (!again || mien::sensor::write_rig(*again) != text) std::abort();
  return 0;
}
