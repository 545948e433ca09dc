#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/session/event_list.h"

// What is read goes by time, and each lasts.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto events = mien::session::parse_event_list(text, "fuzz");
  if (!events) return 0;
  double before_s = -1;
  for (const mien::session::ListedEvent& event : *events) {
    if (!(event.time_s > before_s) || !(event.seconds > 0) || event.name.empty()) std::abort();
    before_s = event.time_s;
  }
  return 0;
}
