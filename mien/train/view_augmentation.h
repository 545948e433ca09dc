#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/random.h"

namespace mien::train {

/// How another camera would show a view, so that a network does not learn the simulation's: as from another
/// mounting, of another gamma, blurred. Stays as it is while a headset is worn.
struct ViewLook {
  double turn_rad = 0, scale = 1;
  double right = 0, down = 0;  ///< Shift, shares of the view's side.
  double gamma = 1;
  bool is_blurred = false;
};
[[nodiscard]] ViewLook draw_look(Random& random);
/// `view`: side x side, grey, changed in place; `memory` is used between calls.
void show_as(const ViewLook& look, std::span<std::uint8_t> view, int side, std::vector<std::uint8_t>& memory);

/// What differs from picture to picture: noise, and a dark or bright patch before it now and then. The same
/// stream gives the same bits.
void spoil_view(std::span<std::uint8_t> view, int side, Random& random);

}  // namespace mien::train
