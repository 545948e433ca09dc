#pragma once

#include <cstddef>

namespace mien::test {

/// Allocations of this program since it began, or under the thread sanitizer since the first call, of all its
/// threads. A program that calls this has its operator new replaced by one that counts.
[[nodiscard]] std::size_t allocation_count();

}  // namespace mien::test
