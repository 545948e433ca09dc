#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "mien/core/random.h"

namespace mien::train {

/// Something before a camera, or a light into it, for a while: not one of the simulator's failures but any
/// shape, texture and glare, so that a network learns to be warned by what it never saw (domain
/// randomisation, Tobin et al. 2017, arXiv:1703.06907).
struct ViewObstacle {
  static constexpr std::size_t kGrid = 6;  ///< Knots of the texture, either way.

  std::size_t begin = 0, end = 0;  ///< Frames [begin, end) in which it is there.
  bool is_glare = false;           ///< Light that is added; it hides where it saturates.
  // An ellipse; lengths are shares of the view's side, from its left upper corner.
  double x = 0.5, y = 0.5, dx = 0, dy = 0;  ///< Middle at `begin`, and its way a frame.
  double long_axis = 1, short_axis = 1, turn_rad = 0;
  double edge = 0.05;                                     ///< Over this it fades.
  double gain = 1;                                        ///< Of what the glare falls on.
  std::array<std::array<float, kGrid>, kGrid> texture{};  ///< Levels, 0 to 255.
};

/// One that is there for part of `frames`.
[[nodiscard]] ViewObstacle draw_obstacle(std::size_t frames, Random& random);
/// Changes `view` (side x side, grey) where the obstacle is in that frame. Returns the share of it that is
/// hidden, by glare where it saturates.
double show_obstacle(const ViewObstacle& obstacle, std::size_t frame, std::span<std::uint8_t> view, int side);

}  // namespace mien::train
