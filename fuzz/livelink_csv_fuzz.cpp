#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/face/livelink_csv.h"

// What parses has rising times and finite values, and once written it comes back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::face;
  const auto csv = parse_livelink_csv({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!csv) return 0;
  for (const LiveLinkRow& row : csv->rows)
    for (const double value : row.values)
      if (!std::isfinite(value)) std::abort();
  const LiveLinkMotion loaded = motion_from_livelink(*csv, "fuzz");
  const auto& frames = loaded.motion.frames;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (!(frames[i].time_s > frames[i - 1].time_s)) std::abort();
  const std::string text = format_livelink_csv(*csv);
  const auto again = parse_livelink_csv(text, "again");
  if (!again || format_livelink_csv(*again) != text) std::abort();
  if (!parse_livelink_csv(format_livelink_csv(livelink_from_motion(loaded.motion)), "exported")) std::abort();
  return 0;
}
