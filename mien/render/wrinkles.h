#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/face/face.h"
#include "mien/face/skin_marks.h"

namespace mien::render {

/// Lines that expressions fold skin into, driven by strain (the field's tension map). Lines of a face have
/// their places, across the pull of its muscles: each region has a pattern of lines at rest, irregular by
/// noise in space, so that it sticks to the skin. Where a pose shortens skin across these lines by more than
/// it takes up elastically, the surplus folds: a sine whose arc is longer than its chord by the share e has
/// slopes of up to 2 sqrt(e). Frame H, metres; strain is change of length over length at rest, negative where
/// shortened. A face without landmarks, or folds of depth 0, has no lines.
class Wrinkles {
 public:
  enum Region : std::uint8_t {
    forehead,    ///< Level, above the brows.
    frown,       ///< Upright, between them.
    crows_feet,  ///< Away from the eye's outer corner.
    under_eye,   ///< Along the lower lid.
    nose_root,   ///< Across the bridge and down its sides: "bunny lines".
    nasolabial,  ///< One fold from the nose's wing past the mouth's corner.
    pucker,      ///< Fine ones, across the lips' border.
    chin,        ///< Dimples without a direction.
    region_count
  };
  /// Slopes of the relief by region, 0 none; at most about 0.7.
  using Slopes = Eigen::Array<float, region_count, 1>;

  Wrinkles(const face::Face& face, const face::SkinFolds& folds);

  [[nodiscard]] bool empty() const { return row_.empty(); }

  /// Slopes of a pose at the vertices that have any; the others' are not touched. Shapes: both beside the
  /// face's neutral; `slopes` begins as zeros.
  void fold(std::span<const Vec3f> vertices_m, std::span<Slopes> slopes) const;

  /// How skin is folded at one place.
  struct Relief {
    Vec3f slope = Vec3f::Zero();  ///< Gradient of the height, in the neutral's space.
    float crease = 0;             ///< How deep in a fold, 0 to about 1.
  };
  /// At a point of the neutral with these slopes; what is finer than a pixel's `footprint_m` fades.
  [[nodiscard]] Relief at(const Vec3f& neutral_m, const Vec3f& normal, const Slopes& slopes,
                          float footprint_m) const;

  /// Strain across the lines of a region at a vertex; 0 where it has none. For tests.
  [[nodiscard]] float strain(Region region, std::uint32_t vertex, std::span<const Vec3f> vertices_m) const;

 private:
  /// Lines lie at whole numbers of `phase`; `weight`, 0 to 1, is where the region is.
  struct Lines {
    float phase = 0, weight = 0;
  };
  /// The stretch across a region's lines at a vertex: length of the sum of coefficient times edge.
  struct Row {
    std::uint32_t vertex = 0, first_term = 0, end_term = 0;
    Region region = forehead;
    float weight = 0;  // Of the slope.
    float share = 1;   // Of the region's strain there.
  };
  struct Term {
    std::uint32_t vertex = 0;
    float coefficient = 0;  // 1/m.
  };
  [[nodiscard]] float phase(Region region, const Vec3f& p) const;
  [[nodiscard]] float weight(Region region, const Vec3f& p) const;
  [[nodiscard]] float row_strain(const Row& row, std::span<const Vec3f> vertices_m) const;
  void add_row(Region region, std::uint32_t vertex, const Vec3f& across, float weight, float share,
               std::span<const Vec3f> neutral_m, std::span<const std::uint32_t> near);

  face::SkinFolds folds_;
  float brow_y_ = 0, glabella_y_ = 0, chin_y_ = 0, front_z_ = 0;
  Vec3f mouth_ = Vec3f::Zero(), nose_root_ = Vec3f::Zero(), nose_middle_ = Vec3f::Zero();
  float mouth_half_m_ = 0.025F;
  std::array<Vec3f, 2> outer_canthus_ = {Vec3f::Zero(), Vec3f::Zero()};  // By side: right, left.
  std::array<Vec3f, 2> inner_canthus_ = {Vec3f::Zero(), Vec3f::Zero()};
  std::array<std::vector<Eigen::Vector2f>, 2> nasolabial_;  // From the nose down, seen from the front.
  std::vector<Row> row_;                                    // By vertex.
  std::vector<Term> term_;
};

}  // namespace mien::render
