#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace mien::app {

/// What a stranger wrote, on one line, without anything that a terminal would obey: control characters, those
/// of UTF-8's second half too, become spaces, and what is beyond `max_bytes` becomes three dots.
[[nodiscard]] std::string one_line(std::string_view text, std::size_t max_bytes = 120);

}  // namespace mien::app
