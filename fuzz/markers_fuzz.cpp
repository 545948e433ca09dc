#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/builtin_face/markers.h"

/// Whatever passes as a set of markers has names, and places near a head.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto set =
      mien::builtin_face::parse_markers(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!set) return 0;
  if (set->markers.empty() || set->markers.size() > 256) std::abort();
  for (const mien::builtin_face::Marker& marker : set->markers)
    if (marker.name.empty() || !marker.position_m.allFinite()) std::abort();
  return 0;
}
