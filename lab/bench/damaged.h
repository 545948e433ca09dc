#pragma once

#include <cstddef>
#include <vector>

#include "mien/core/random.h"

namespace mien::lab {

/// A datagram with something wrong in it: bits turned over, its end cut off, or bytes behind it. Every second
/// time it ends with the checksum that our packets have, and it is right all the same, so that what lies
/// behind it is reached. Not empty.
[[nodiscard]] std::vector<std::byte> damaged(std::vector<std::byte> datagram, Random& random);

/// Its last bytes become the checksum of what stands before them; nothing of fewer bytes is changed.
void mend_checksum(std::vector<std::byte>& datagram);

}  // namespace mien::lab
