#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/random.h"

namespace mien::train {

/// A view as another camera would have taken it, so that a network does not learn the simulation's: shifted,
/// turned and scaled as by another mounting, brighter, duller, of another gamma, blurred or noisy, with a
/// dark or bright patch before it now and then. `view`: side x side, grey, changed in place; `memory` is used
/// between calls. The same stream gives the same bits.
void augment_view(std::span<std::uint8_t> view, int side, Random& random, std::vector<std::uint8_t>& memory);

}  // namespace mien::train
