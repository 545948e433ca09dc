#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace mien::app {

/// What a stranger wrote, on one line, without anything that a terminal would obey, as excerpt() has it: line
/// ends become blanks, other controls and what turns the direction of writing '?', and what is beyond
/// `max_letters` becomes three dots.
[[nodiscard]] std::string one_line(std::string_view text, std::size_t max_letters = 120);

}  // namespace mien::app
