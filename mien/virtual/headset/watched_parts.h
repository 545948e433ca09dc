#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/face/face.h"
#include "mien/render/lens.h"

namespace mien::virt {

/// What of a face a camera is there for: skin that its region's shapes move, the lids' or the mouth's, spread
/// evenly over what its view shows where the headset was fitted.
[[nodiscard]] std::vector<std::uint32_t> watched_vertices(const face::Face& face, bool of_mouth,
                                                          const render::Lens& lens);

/// A thing before the face: triangles of places in frame H.
struct HidingMesh {
  std::span<const Vec3f> vertices_m;
  std::span<const std::array<std::uint32_t, 3>> triangles;
};

/// A half of the face of which its views have more than this share hidden, in the mean, cannot be seen.
inline constexpr double kMostHidden = 0.25;

/// Gathers what views hide of the two halves of a face, 0 the upper and 1 the lower one.
class SeenHalves {
 public:
  /// A view of `half`, and the share of it that is hidden, 0 to 1.
  void add(std::size_t half, double hidden) {
    hidden_[half] += hidden;
    ++views_[half];
  }
  /// By kMostHidden; a half that no view is there for counts as seen.
  [[nodiscard]] std::array<bool, 2> seen() const {
    return {hidden_[0] <= kMostHidden * views_[0], hidden_[1] <= kMostHidden * views_[1]};
  }

 private:
  std::array<double, 2> hidden_{}, views_{};  // Sums, and of how many.
};

/// The share of `watched` that a view does not show, 0 to 1: out of it, behind `thing`, or so bright or
/// dark that `picture` (grey, as large as the lens's; empty: nothing is) has it white or black. What the face
/// itself covers counts as shown. `face_m`: the face's vertices. Cost: watched vertices times triangles.
[[nodiscard]] double hidden_share(std::span<const std::uint32_t> watched, std::span<const Vec3f> face_m,
                                  const HidingMesh& thing, const render::Lens& lens,
                                  std::span<const std::uint8_t> picture);

}  // namespace mien::virt
