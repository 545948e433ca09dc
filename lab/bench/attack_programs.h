#pragma once

#include <memory>

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

}  // namespace mien::lab
