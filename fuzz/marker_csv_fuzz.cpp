#include <cstdint>
#include <string_view>

#include "fuzz/marker_round_trip.h"
#include "mien/mocap/marker_csv.h"

// Ours and Motive's.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::mocap;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  (void)is_marker_csv(text);
  const auto read = is_motive_csv(text) ? parse_motive_csv(text, "fuzz") : parse_marker_csv(text, "fuzz");
  if (read) expect_marker_round_trip(read->track, format_marker_csv, parse_marker_csv, true);
  return 0;
}
