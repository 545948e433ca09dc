#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace mien {

/// Letters of a file that a message repeats.
inline constexpr std::size_t kExcerptLetters = 40;
/// Letters of what a library says of a file: it may repeat some of it behind its own words.
inline constexpr std::size_t kComplaintLetters = 120;

/// What a file or a stranger says, as a message repeats it: its first letters, and "..." where there are
/// more. Line ends and tabs become blanks, and what else is no printable letter '?': control characters,
/// which a terminal would obey, those that turn the direction of writing, and bytes that are no UTF-8.
[[nodiscard]] std::string excerpt(std::string_view text, std::size_t letters = kExcerptLetters);

/// The same of a whole text, as long as it is: for who shows what others have put together.
[[nodiscard]] std::string without_controls(std::string_view text);

}  // namespace mien
