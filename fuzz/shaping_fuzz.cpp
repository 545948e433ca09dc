#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/shaping/centre.h"
#include "mien/shaping/resting_face.h"
#include "mien/shaping/settings.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::shaping;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  // What was accepted is written as text that reads back equal.
  if (const auto settings = parse_settings(text, "input")) {
    const auto again = parse_settings(write_settings(*settings), "written");
    if (!again || *again != *settings) std::abort();
  }
  if (const auto centre = parse_centre(text, "input")) {
    const auto again = parse_centre(write_centre(*centre), "written");
    if (!again || *again != *centre) std::abort();
  }
  if (const auto resting = parse_resting_face(text, "input")) {
    const auto again = parse_resting_face(write_resting_face(*resting), "written");
    if (!again || *again != *resting) std::abort();
  }
  return 0;
}
