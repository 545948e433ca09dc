#include "mien/virtual/headset/timed_failure.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string>

#include "mien/core/excerpt.h"
#include "mien/virtual/headset/headset_simulator.h"

namespace mien::virt {
namespace {

/// All of the text, as a time that is not before the motion's start.
std::optional<double> seconds_in(std::string_view text) {
  double seconds = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(seconds) || seconds < 0)
    return std::nullopt;
  return seconds;
}

}  // namespace

Result<TimedFailure> parse_timed_failure(std::string_view text) {
  const std::string_view name = text.substr(0, text.find('@'));
  const auto failure = failure_named(name);
  if (!failure || *failure == HeadsetFailure::none) {
    std::string all;
    for (std::size_t i = 1; i < kHeadsetFailures; ++i)
      all += fmt::format("{}{}", i == 1 ? "" : ", ", failure_name(static_cast<HeadsetFailure>(i)));
    return fail(ErrorCode::bad_usage, "no such failure of a headset", excerpt(name), "it may be " + all);
  }
  TimedFailure timed{.failure = *failure};
  if (name.size() == text.size()) return timed;
  const std::string_view times = text.substr(name.size() + 1);
  const std::size_t dash = times.find('-');
  if (dash != std::string_view::npos) {
    timed.from_s = seconds_in(times.substr(0, dash));
    const std::string_view end = times.substr(dash + 1);
    if (!end.empty()) timed.to_s = seconds_in(end);
    if (timed.from_s && (end.empty() || (timed.to_s && *timed.from_s < *timed.to_s))) return timed;
  }
  return fail(ErrorCode::bad_usage, "no times of a failure", excerpt(text),
              fmt::format("write {0}@4-9 for 4 to 9 s after the motion's start, or {0}@4-", name));
}

}  // namespace mien::virt
