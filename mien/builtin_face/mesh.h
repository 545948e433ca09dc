#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "mien/builtin_face/albedo.h"
#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::builtin_face {

/// What a vertex belongs to: decides how it follows the face and how it is painted.
enum class Tissue : std::uint8_t {
  skin,        ///< Outer skin, lids' outside included.
  lip,         ///< The red of the lips.
  mouth,       ///< Inside of lips and cheeks.
  lid_inside,  ///< Margin and inside of a lid.
  tear,        ///< The film of tears on the lower lid's edge.
  caruncle,    ///< In the inner corner of the eye.
  ear,
  eyeball,
  teeth_upper,
  teeth_lower,
  gums_upper,
  gums_lower,
  tongue,
  lash,
  brow,
  cloth,
};

struct SculptVertex {
  Vec3 p = Vec3::Zero();       ///< mm, frame H.
  Vec3 anchor = Vec3::Zero();  ///< Where on the skin it grows (brows, lashes); else p.
  Tissue tissue = Tissue::skin;
  double lip_side = 0;  ///< 1 goes with the upper lip, -1 with the lower.
  double lid = 0;       ///< 1 at the upper lid's margin to 0 at the socket's rim; negative on the lower lid.
  Vec3f colour = Vec3f::Ones();
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();  ///< Of lashes and brows, as face::Material::strands has it.
  /// Where a texture shows it (texture_layout): of skin and lips azimuth (rad) and row of the sculptor's ray,
  /// of ears and eyeballs distance from the chart's middle, 0 to 1, and direction (rad).
  Eigen::Vector2d chart = Eigen::Vector2d::Zero();
};

/// Lips, the mouth's lining, and the skin beside the lips.
[[nodiscard]] inline bool may_touch_teeth(const SculptVertex& v) {
  const bool beside_lips = v.tissue == Tissue::skin && v.p.z() > 85 && std::abs(v.p.y() - kMouthCornerY) < 17;
  return v.tissue == Tissue::lip || v.tissue == Tissue::mouth || beside_lips;
}

/// Groups of triangles, in the order in which Face::parts has them.
enum class Piece : std::uint8_t {
  skin,
  ears,
  lips,
  mouth,
  lids,
  tears,
  caruncles,
  sclera_l,
  iris_l,
  pupil_l,
  sclera_r,
  iris_r,
  pupil_r,
  teeth_upper,
  gums_upper,
  teeth_lower,
  gums_lower,
  tongue,
  lashes,
  brows,
  shirt,
  count
};
inline constexpr std::size_t kPieceCount = static_cast<std::size_t>(Piece::count);

/// A head while it is being made.
struct Sculpt {
  std::vector<SculptVertex> vertices;
  std::vector<std::uint32_t> mirror;  ///< The vertex at (-x, y, z); itself on the midline.
  std::array<std::vector<std::array<std::uint32_t, 3>>, kPieceCount> triangles;
  std::array<face::Eyeball, 2> eyes;  ///< Left, right; centres in mm.

  std::uint32_t add(const SculptVertex& v) {
    vertices.push_back(v);
    return static_cast<std::uint32_t>(vertices.size() - 1);
  }
  void triangle(Piece piece, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) triangles[static_cast<std::size_t>(piece)].push_back({a, b, c});
  }
  /// Corners counter-clockwise from outside; split along the shorter diagonal.
  void quad(Piece piece, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    const bool ac =
        (vertices[a].p - vertices[c].p).squaredNorm() <= (vertices[b].p - vertices[d].p).squaredNorm();
    if (ac) {
      triangle(piece, a, b, c);
      triangle(piece, a, c, d);
    } else {
      triangle(piece, b, c, d);
      triangle(piece, b, d, a);
    }
  }
};

using Ring = std::vector<std::uint32_t>;

/// A vertex that grows where it stands.
[[nodiscard]] inline SculptVertex vertex(const Vec3& p, Tissue tissue, double lip_side = 0) {
  SculptVertex v;
  v.p = v.anchor = p;
  v.tissue = tissue;
  v.lip_side = lip_side;
  return v;
}

/// Sews two rings of equal size; seen from outside, `a` to `b` goes up while the index goes right. `closed`
/// joins last to first.
inline void sew(Sculpt& half, Piece piece, const Ring& a, const Ring& b, bool closed) {
  for (std::size_t i = 0; i + (closed ? 0 : 1) < a.size(); ++i) {
    const std::size_t j = (i + 1) % a.size();
    half.quad(piece, a[i], a[j], b[j], b[i]);
  }
}

/// The left half of the outer skin with lids and mouth: a grid of columns and rows, and rings of edges about
/// eye and mouth.
void add_skin(Sculpt& half);

/// An outer ear on its own plane, turned out from the head: rim, ridge, bowl, tragus and lobe as relief on a
/// disc.
void add_ear(Sculpt& half);

/// Teeth, gums and tongue.
void add_mouth_parts(Sculpt& half);

/// Lashes and brow, as ribbons of strands.
void add_brows_and_lashes(Sculpt& half);

/// The shirt that the neck ends in.
void add_shirt(Sculpt& half);

/// Both halves from the left one; vertices on the midline are shared. Eyeballs come last and whole.
[[nodiscard]] Sculpt mirrored(const Sculpt& half);

/// Two eyeballs at their places, each a contiguous run of vertices.
void add_eyeballs(Sculpt& whole);

/// The default head, sculpted once; vertices are numbered as those of every built-in face without hair.
[[nodiscard]] const Sculpt& default_sculpt();

/// Multi-PIE's 68 on the sculpted head: each the vertex nearest to its place, the right ones mirrored.
[[nodiscard]] std::array<std::uint32_t, 68> find_landmarks(const Sculpt& s);

/// The regions of Face::regions, by place and tissue.
[[nodiscard]] std::vector<face::Region> find_regions(const Sculpt& s);

/// How far brows of this fullness (BuiltinParameters) reach above and below their middle; 1 the default's.
[[nodiscard]] inline double brow_spread(double brow_fullness) {
  return 1 + 0.22 * std::clamp(brow_fullness, -3.0, 3.0);
}

/// Where a beard grows on the default head (mm), 0 to 1: lip, chin, jaw and the throat below, up to the
/// sideburns.
[[nodiscard]] double beard_amount(const Vec3& p);

/// Colours of vertices by place and tissue, of these reflectances.
[[nodiscard]] std::vector<Vec3f> paint(const Sculpt& whole, const BuiltinParameters& parameters,
                                       const Albedos& albedos);

}  // namespace mien::builtin_face
