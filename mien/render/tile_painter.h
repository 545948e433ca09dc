#pragma once

#include <array>
#include <cstddef>

#include "mien/render/renderer_state.h"

namespace mien::render {

/// Draws one tile after another of the pose that was lit: what each sample sees is found once, for pictures
/// of the face and of its errors alike. One thread each.
class Renderer::State::TilePainter {
 public:
  explicit TilePainter(State& state) : s_(state) {}

  void begin(std::size_t tile);
  /// Draws the tile that was begun into a picture.
  void paint(const ErrorColours* errors, Image* picture);

 private:
  /// What some samples of a pixel see: the same surface, of which one place is shaded for all of them.
  struct Surface {
    std::uint32_t triangle = TileDepths::kNothing;
    Coverage samples = 0;      // All of it.
    Coverage of_triangle = 0;  // Those of `triangle`.
    float inverse_depth = 0;   // Of its first sample; 0 where nothing is.
  };
  using Surfaces = std::array<Surface, kSamples>;

  /// Finds what the samples of the tile see.
  void see();
  void gather_hair(HairLight* colours);
  [[nodiscard]] bool has_no_error(const ErrorColours& errors) const;
  /// How many surfaces a pixel shows.
  std::size_t find_surfaces(int x, int y, Surfaces* surfaces) const;
  [[nodiscard]] bool same(const Surface& surface, std::uint32_t triangle, float inverse_depth) const;
  [[nodiscard]] Vec3f colour_of(const Surface& surface, int x, int y, const ErrorColours* errors) const;
  [[nodiscard]] SeenPlace place(std::uint32_t triangle, Coverage samples, int x, int y) const;
  /// Light from hair before a surface; `through` becomes what it lets through.
  [[nodiscard]] Vec3f hair_before(const Surface& surface, int pixel, float* through) const;
  [[nodiscard]] Vec3f pixel_colour(int x, int y, const ErrorColours* errors) const;

  State& s_;
  std::size_t tile_ = 0;
  bool rests_ = false, is_seen_ = false;
  int left_ = 0, top_ = 0;
  const TileDepths* solid_ = nullptr;
  TileDepths own_solid_, clear_;
  TileHair moving_, not_kept_;
  const TileHair* still_ = nullptr;
};

}  // namespace mien::render
