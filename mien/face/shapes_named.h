#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace mien::face {

/// The shape of that name; both sides, the left first, of a pair whose name it is without "_L" and "_R"; none
/// for any other name.
[[nodiscard]] std::vector<std::size_t> shapes_named(std::string_view name);

}  // namespace mien::face
