#include "mien/headset/picture_fault.h"

#include <array>

namespace mien::headset {

std::string_view name_of(PictureFault fault) {
  constexpr std::array<std::string_view, kPictureFaults> kNames = {
      "not a JPEG",  "truncated", "too long",   "too large",    "no size",       "repeated size",
      "progressive", "lossless",  "arithmetic", "hierarchical", "not of 8 bits", "components",
      "sampling",    "scans",     "tables",     "damaged"};
  return kNames[static_cast<std::size_t>(fault)];
}

}  // namespace mien::headset
