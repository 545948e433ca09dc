#include "mien/session/event_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "mien/core/excerpt.h"
#include "mien/session/prompt.h"

namespace mien::session {
namespace {

constexpr std::string_view kHead = "time_s,name";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr double kLatest_s = 1e6;

}  // namespace

Result<std::vector<ListedEvent>> parse_event_list(std::string_view csv, const std::string& where) {
  std::vector<ListedEvent> events;
  if (csv.starts_with(kByteOrderMark)) csv.remove_prefix(kByteOrderMark.size());
  bool head = false;
  for (std::size_t number = 1; !csv.empty(); ++number) {
    const std::size_t end = std::min(csv.size(), csv.find('\n'));
    std::string_view line = csv.substr(0, end);
    csv.remove_prefix(std::min(csv.size(), end + 1));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) continue;
    const std::string place = fmt::format("{}, line {}", where, number);
    if (!head) {
      if (line != kHead)
        return fail(ErrorCode::malformed, fmt::format("it begins with '{}'", excerpt(line)), place,
                    fmt::format("begin it with the line '{}'", kHead));
      head = true;
      continue;
    }
    ListedEvent event;
    const std::size_t comma = std::min(line.size(), line.find(','));
    const auto [read, wrong] = std::from_chars(line.data(), line.data() + comma, event.time_s);
    if (wrong != std::errc{} || read != line.data() + comma || comma == line.size())
      return fail(ErrorCode::malformed, fmt::format("'{}' is no time and name", excerpt(line)), place,
                  "write it like 12.5,smile");
    if (!(event.time_s >= 0 && event.time_s <= kLatest_s))
      return fail(ErrorCode::out_of_range, fmt::format("a time of {:g} s", event.time_s), place,
                  "count seconds from the first picture");
    if (!events.empty() && !(event.time_s > events.back().time_s))
      return fail(ErrorCode::out_of_range, "its time is not after that of the line before", place,
                  "sort the lines by time");
    if (events.size() == kMaxPrompts)
      return fail(ErrorCode::out_of_range, fmt::format("over {} lines", kMaxPrompts), place,
                  "leave some out");
    event.name = line.substr(comma + 1);
    event.seconds = kListed_s;
    MIEN_TRY(check_prompt({.name = event.name, .say = {}, .seconds = kListed_s, .target = {}}, place));
    if (!events.empty()) events.back().seconds = std::min(kListed_s, event.time_s - events.back().time_s);
    events.push_back(std::move(event));
  }
  if (!head)
    return fail(ErrorCode::malformed, "it is empty", where,
                fmt::format("begin it with the line '{}'", kHead));
  return events;
}

}  // namespace mien::session
