#include <cstdint>
#include <string_view>

#include "fuzz/marker_round_trip.h"
#include "mien/mocap/trc.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::mocap;
  const auto read = parse_trc({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (read) expect_marker_round_trip(read->track, format_trc, parse_trc, false);
  return 0;
}
