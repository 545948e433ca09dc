#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "app/live/session_message.h"

// What answers at a session's address may say anything; what is taken from it is finite.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::app;
  const auto message = parse_session_message({reinterpret_cast<const char*>(data), size});
  if (!message) return 0;
  if (const auto* status = std::get_if<SessionStatus>(&*message)) {
    if (!std::isfinite(status->time_s) || !std::isfinite(status->calibration.progress)) std::abort();
    for (const auto& version : status->calibration.versions)
      for (const auto& score : version.scores)
        if (!std::isfinite(score.value)) std::abort();
  }
  return 0;
}
