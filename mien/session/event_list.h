#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::session {

/// Something that a person was asked for while somebody else recorded.
struct ListedEvent {
  double time_s = 0;   ///< From the recording's first picture, 0 to 1e6.
  double seconds = 0;  ///< Until the next one begins, kListed_s at most.
  std::string name;    ///< As Prompt::name.
  bool operator==(const ListedEvent&) const = default;
};

/// What is asked for lasts no longer than this, as the neutral of a calibration does.
inline constexpr double kListed_s = 3;

/// Reads a CSV of prompts: a first line "time_s,name", then a line each, by time. A name may have commas.
/// Empty lines, a byte order mark and line ends of any system are passed over. `where` names the source in
/// messages. Errors, with the line: malformed (another head, a line without a time or a name), out_of_range
/// (a time that is not after the one before, or beyond 1e6; a name that check_prompt refuses; over
/// kMaxPrompts lines).
[[nodiscard]] Result<std::vector<ListedEvent>> parse_event_list(std::string_view csv,
                                                                const std::string& where);

}  // namespace mien::session
