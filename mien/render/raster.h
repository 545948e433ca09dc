#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/render/camera.h"

// What a camera sees of triangles: each is cut into the pixels and samples that it covers, a tile of the
// picture at a time. Exact: corners are rounded to a grid, and neighbours neither overlap nor leave a gap.
namespace mien::render {

/// Places of a pixel at which it is asked what covers it: a rotated grid, which no two lie on a row or column
/// of.
inline constexpr int kSamples = 4;
/// Corners are rounded to this many places of a pixel, and samples lie on them.
inline constexpr int kSubpixels = 16;
/// Of the samples, x and y from a pixel's upper left corner.
inline constexpr std::array<std::array<int, 2>, kSamples> kSampleAt = {{{6, 2}, {14, 6}, {2, 10}, {10, 14}}};
/// Which samples are covered, a bit each.
using Coverage = std::uint32_t;
inline constexpr Coverage kWholePixel = (1U << kSamples) - 1;

/// How many samples are covered.
[[nodiscard]] constexpr int count_of(Coverage coverage) {
  static_assert(kSamples == 4);
  return static_cast<int>((coverage & 1U) + (coverage >> 1U & 1U) + (coverage >> 2U & 1U) +
                          (coverage >> 3U & 1U));
}

/// Side of a tile, pixels.
inline constexpr int kTile = 32;
inline constexpr int kTilePixels = kTile * kTile;

/// A vertex as the camera sees it: x to the right and y down from the picture's upper left corner.
struct ScreenPoint {
  std::int32_t x = 0, y = 0;  ///< Subpixels.
  float inverse_depth = 0;    ///< Per metre along the line of sight; 0 where the camera cannot see it.
};

/// A camera ready to be asked. Pixels are those of its picture times `finer`.
class Projection {
 public:
  Projection() = default;
  explicit Projection(const Camera& camera, int finer = 1);
  [[nodiscard]] ScreenPoint project(const Vec3f& p_m) const;
  /// Towards what is seen at x, y (pixels); unit, frame H.
  [[nodiscard]] Vec3f ray(float x, float y) const;

  int width = 0, height = 0;  ///< Pixels.
  Vec3f eye_m = Vec3f::Zero(), forward = Vec3f::UnitZ(), right = Vec3f::UnitX(), up = Vec3f::UnitY();
  float pixel = 1;        ///< Tangent of the angle that one fills.
  float footprint_m = 0;  ///< What a pixel spans at the camera's target.
};

/// Pixels [left, right) x [top, bottom).
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
  [[nodiscard]] bool empty() const { return left >= right || top >= bottom; }
};

/// Whether corners that go counter-clockwise on the outside are seen from the inside.
[[nodiscard]] inline bool faces_away(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c) {
  return (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y) >
         (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - a.x);
}

/// A triangle on the screen.
class ScreenTriangle {
 public:
  ScreenTriangle(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c);

  /// The pixels in which samples may be covered; empty where it is degenerate or not before the camera.
  [[nodiscard]] const PixelBox& box() const { return box_; }

  /// Calls cover(x, y, coverage) for each pixel of `within` of which a sample is covered, row by row.
  template <class Cover>
  void scan(const PixelBox& within, const Cover& cover) const {
    const PixelBox part = {std::max(box_.left, within.left), std::max(box_.top, within.top),
                           std::min(box_.right, within.right), std::min(box_.bottom, within.bottom)};
    if (part.empty()) return;
    if (large_)
      scan_as<std::int64_t>(part, cover);
    else
      scan_as<std::int32_t>(part, cover);
  }

  /// Shares of the corners in what is seen at x, y (pixels), in perspective; sum 1.
  [[nodiscard]] std::array<float, 3> weights(float x, float y) const;
  /// The same on the screen, without perspective.
  [[nodiscard]] std::array<float, 3> flat_weights(float x, float y) const;
  /// Of a field given at the corners, how fast it changes to the right and down, per pixel, on the screen.
  [[nodiscard]] Eigen::Vector2f gradient(const std::array<float, 3>& field) const;
  /// Pixels.
  [[nodiscard]] const Eigen::Vector2f& first_corner() const { return corner_[0]; }
  /// Of each corner, per metre; linear on the screen.
  [[nodiscard]] const std::array<float, 3>& inverse_depth() const { return inverse_depth_; }

 private:
  template <class Int, class Cover>
  void scan_as(const PixelBox& part, const Cover& cover) const {
    // An edge function is positive on the inside; of a place on an edge, the triangle has it whose left or
    // upper edge it is.
    std::array<Int, 3> across{}, down{}, at_corner{};
    std::array<std::array<Int, kSamples>, 3> sample{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const Int dx = Int{x_[next]} - x_[k], dy = Int{y_[next]} - y_[k];
      const bool owns = dy < 0 || (dy == 0 && dx > 0);
      at_corner[k] = dx * (Int{part.top} * kSubpixels - y_[k]) - dy * (Int{part.left} * kSubpixels - x_[k]) -
                     (owns ? 0 : 1);
      across[k] = -dy * kSubpixels;
      down[k] = dx * kSubpixels;
      for (std::size_t s = 0; s < kSamples; ++s) sample[k][s] = dx * kSampleAt[s][1] - dy * kSampleAt[s][0];
    }
    for (int y = part.top; y < part.bottom; ++y) {
      std::array<Int, 3> at = at_corner;
      for (int x = part.left; x < part.right; ++x) {
        Coverage coverage = 0;
        for (std::size_t s = 0; s < kSamples; ++s) {
          const Int outside = (at[0] + sample[0][s]) | (at[1] + sample[1][s]) | (at[2] + sample[2][s]);
          coverage |= static_cast<Coverage>(outside >= 0) << s;
        }
        if (coverage != 0) cover(x, y, coverage);
        for (std::size_t k = 0; k < 3; ++k) at[k] += across[k];
      }
      for (std::size_t k = 0; k < 3; ++k) at_corner[k] += down[k];
    }
  }

  std::array<std::int32_t, 3> x_{}, y_{};  // Turned so that the inside of each edge is positive.
  bool large_ = false;                     // Too large for 32-bit edge functions.
  PixelBox box_;
  std::array<Eigen::Vector2f, 3> corner_;  // Pixels, in the order given.
  float inverse_area_ = 0;
  std::array<float, 3> inverse_depth_{};
};

/// The middle of the covered samples, pixels from the pixel's upper left corner.
[[nodiscard]] Eigen::Vector2f middle_of(Coverage coverage);

/// For each tile of a picture the triangles that may cover some of it, in their order.
class TileBins {
 public:
  /// `listed`: which of all `triangles`.
  void sort(std::span<const std::uint32_t> listed, std::span<const std::array<std::uint32_t, 3>> triangles,
            std::span<const ScreenPoint> points, int width, int height);
  [[nodiscard]] std::size_t count() const { return start_.size() - 1; }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t tile) const {
    return std::span(triangle_).subspan(start_[tile], start_[tile + 1] - start_[tile]);
  }

 private:
  std::vector<std::uint32_t> start_, triangle_;
  std::vector<PixelBox> tiles_;  // Of each listed triangle.
};

/// How many tiles lie side by side in a picture this wide (or high).
[[nodiscard]] constexpr int tiles_in(int pixels) {
  return (pixels + kTile - 1) / kTile;
}

/// Of each sample of one tile, the nearest triangle.
class TileDepths {
 public:
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  TileDepths();
  /// Begins the tile whose upper left pixel is this.
  void clear(int left, int top);
  /// Into these of each pixel's samples.
  void draw(std::uint32_t triangle, const ScreenTriangle& on_screen, Coverage samples = kWholePixel);
  /// Of what is drawn so far, for hides().
  void find_farthest();
  /// Whether a triangle of these corners is nowhere nearer than what find_farthest() met. It may be hidden
  /// although this says no.
  [[nodiscard]] bool hides(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c) const;
  /// Both of a sample; x and y in the picture, inside the tile.
  [[nodiscard]] std::uint32_t triangle(int x, int y, int sample) const { return triangle_[at(x, y, sample)]; }
  [[nodiscard]] float inverse_depth(int x, int y, int sample) const {
    return inverse_depth_[at(x, y, sample)];
  }
  /// Of all samples.
  [[nodiscard]] std::span<const std::uint32_t> triangles() const { return triangle_; }
  /// Whether nothing was drawn.
  [[nodiscard]] bool empty() const { return empty_; }

 private:
  [[nodiscard]] std::size_t at(int x, int y, int sample) const {
    return static_cast<std::size_t>(((y - top_) * kTile + x - left_) * kSamples + sample);
  }
  int left_ = 0, top_ = 0;
  bool empty_ = true;
  /// Side of the blocks of pixels of which the farthest is known.
  static constexpr int kBlock = 8, kBlocks = kTile / kBlock;
  std::array<float, std::size_t{kBlocks} * kBlocks> farthest_{};  // Inverse depth; row by row.
  std::vector<float> inverse_depth_;
  std::vector<std::uint32_t> triangle_;
};

}  // namespace mien::render
