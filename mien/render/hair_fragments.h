#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/render/raster.h"

namespace mien::render {

/// What one triangle of a ribbon of hair (or a card of lashes) shows in one pixel.
struct HairFragment {
  float inverse_depth = 0;      ///< Per metre.
  float cover = 0;              ///< How much of the covered samples is hair, 0 to 1.
  Vec3f light = Vec3f::Zero();  ///< What the hair sends to the camera, linear RGB.
  std::uint16_t pixel = 0;      ///< Of its tile, row by row.
  std::uint8_t samples = 0;     ///< Coverage.
};

/// Less than this coming through hair is nothing.
inline constexpr float kOpaque = 0.03F;

/// The hair before the pixels of one tile, of each pixel the nearest first.
class TileHair {
 public:
  void clear();  ///< Begins anew.
  void add(const HairFragment& fragment) { fragment_.push_back(fragment); }
  /// Once after the last one: sorts them by depth, and drops what others hide.
  void sort();
  [[nodiscard]] bool is_sorted() const { return is_sorted_; }
  [[nodiscard]] std::span<const HairFragment> of(int pixel) const {
    if (fragment_.empty()) return {};
    const std::uint32_t first = start_[static_cast<std::size_t>(pixel)];
    return std::span(fragment_).subspan(first, start_[static_cast<std::size_t>(pixel) + 1] - first);
  }
  [[nodiscard]] bool empty() const { return fragment_.empty(); }

 private:
  std::vector<HairFragment> fragment_;
  std::vector<std::uint32_t> start_;  // Of each pixel; one more.
  bool is_sorted_ = false;
};

}  // namespace mien::render
