#pragma once

#include <string_view>

namespace mien {

/// Whether two secrets (a token that was sent, and the right one) are the same. How long that takes tells
/// nothing but whether they are equally long. No allocation.
[[nodiscard]] bool same_secret(std::string_view a, std::string_view b);

}  // namespace mien
