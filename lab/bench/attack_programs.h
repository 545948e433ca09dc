#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lab/bench/attack.h"
#include "mien/core/random.h"

namespace mien::lab {

/// Eye trackers' OSC: rounds of coordinates as they should be, and messages that lie about their types,
/// numbers, lengths and depth.
[[nodiscard]] std::unique_ptr<Speech> osc_programs(const Victims& victims, Random random);

/// Our packets of gaze and of weights (types 11 and 12): as they should be, damaged, and with numbers that
/// none should have. As the rig's own programs where it has some, else as programs that nobody knows.
[[nodiscard]] std::unique_ptr<Speech> face_programs(const Victims& victims, Random random);

/// Phones with Live Link Face, two sockets of the same id each: packets as they should be, damaged, of
/// another name, of an hour later, without a face, and with numbers that none should have.
[[nodiscard]] std::unique_ptr<Speech> face_phones(const Victims& victims, Random random);

/// A datagram with something wrong in it: bits turned over, its end cut off, or bytes behind it. Every second
/// time it ends with the checksum that our packets have, and it is right all the same, so that what lies
/// behind it is reached. Not empty.
[[nodiscard]] std::vector<std::byte> damaged(std::vector<std::byte> datagram, Random& random);

/// Its last bytes become the checksum of what stands before them; nothing of fewer bytes is changed.
void mend_checksum(std::vector<std::byte>& datagram);

}  // namespace mien::lab
