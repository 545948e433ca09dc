#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace mien::lab {

/// Columns of a tracker's table, at most; no more cells of a line are looked at.
inline constexpr std::size_t kMaxTableColumns = 1024;

/// Without blanks and quotes around it.
[[nodiscard]] std::string_view trimmed_cell(std::string_view text);
/// Cuts the first line from the text; a carriage return at its end stays.
[[nodiscard]] std::string_view cut_line(std::string_view& text);
/// What stands between commas, trimmed: of a line with more than kMaxTableColumns columns one cell more.
[[nodiscard]] std::vector<std::string_view> table_cells(std::string_view line);
/// The whole cell as a number; nothing where it is none, or not finite.
[[nodiscard]] std::optional<double> number_in(std::string_view cell);

}  // namespace mien::lab
