#pragma once

#include <array>
#include <vector>

#include "mien/face/face.h"
#include "mien/face/skin_marks.h"

namespace mien::render {

/// What light meets at one point.
struct Surface {
  Vec3f albedo = Vec3f::Constant(0.5F);  ///< Linear RGB.
  float roughness = 0.5F;                ///< 0 mirror to 1 chalk.
  float reflectance = 0.03F;             ///< Mirror reflection straight on.
  float scatter = 0;                     ///< 1: light spreads under it as in skin; 0: not at all.
  float bump = 0;                        ///< Strength of pores.
};

/// Of each triangle; skin where no part has it.
[[nodiscard]] std::vector<face::Material> material_of_triangles(const face::Face& face);

/// What is known of a place beside its material and colour.
struct Place {
  Eigen::Vector2f marks = Eigen::Vector2f::Zero();  ///< face::SkinMarks::amount, interpolated.
  float footprint_m = 0;  ///< How much of the skin one pixel shows: finer things are averaged or left out.
};

/// Colours of a face: its own where it has them, else those of its materials with lips, brows, flush and
/// irises painted from landmarks and eyeballs. All in the neutral's space, so paint moves with the skin.
class SurfacePaint {
 public:
  explicit SurfacePaint(const face::Face& face, face::SkinMarks marks = {});

  /// At a point of the neutral on a triangle of this material; `own` is the interpolated face colour where it
  /// has any.
  [[nodiscard]] Surface at(const Vec3f& neutral_m, face::Material material, const Vec3f* own,
                           const Place& place = {}) const;

  /// Freckles, moles and stubble; amounts stand beside the face's vertices or are none.
  [[nodiscard]] const face::SkinMarks& marks() const { return marks_; }

  /// How much of a lash card is hair, 0 to 1, at a point of the neutral `length_m` away from the lid.
  [[nodiscard]] float lash_cover(const Vec3f& neutral_m, float length_m) const;

  /// Of eyeball `eye`: the angle about its centre at which the iris ends.
  [[nodiscard]] float iris_angle_rad(int eye) const { return iris_angle_rad_[static_cast<std::size_t>(eye)]; }

  /// Where that eyeball looks in the neutral, unit, frame H.
  [[nodiscard]] const Vec3f& eye_axis(int eye) const { return eye_axis_[static_cast<std::size_t>(eye)]; }

 private:
  struct Spot {
    Vec3f centre_m;
    float radius_m;
    Vec3f tint;  // Factor on the albedo at the centre.
  };
  struct Oily {
    Vec3f centre_m, radius_m;
  };
  [[nodiscard]] Surface eye(const Vec3f& neutral_m, int index) const;
  [[nodiscard]] float lip_amount(const Vec3f& neutral_m) const;
  [[nodiscard]] float brow_amount(const Vec3f& neutral_m) const;

  /// Skin's own colour with its marks and pores.
  [[nodiscard]] Vec3f marked(const Vec3f& albedo, const Vec3f& neutral_m, const Place& place) const;

  const face::Face& face_;
  face::SkinMarks marks_;
  bool outlines_lips_ = false;
  bool paints_brows_ = false;
  std::vector<Spot> spots_;
  std::vector<Oily> oily_;               // Nose and forehead shine.
  std::vector<Eigen::Vector2f> lips_m_;  // Closed outline, seen from the front.
  Eigen::AlignedBox2f lips_box_;
  std::array<Eigen::AlignedBox2f, 2> brows_box_;
  float lips_back_m_ = 0;                                // Lips lie in front of this z.
  std::array<std::vector<Eigen::Vector2f>, 2> brows_m_;  // From the nose outwards.
  float brows_back_m_ = 0;
  std::array<Vec3f, 2> eye_axis_ = {Vec3f::UnitZ(), Vec3f::UnitZ()};
  std::array<float, 2> iris_angle_rad_ = {0.46F, 0.46F};
  std::array<Vec3f, 2> iris_colour_ = {Vec3f(0.085F, 0.13F, 0.155F), Vec3f(0.085F, 0.13F, 0.155F)};
};

}  // namespace mien::render
