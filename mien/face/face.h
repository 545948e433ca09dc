#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/profile.h"

namespace mien::face {

/// One blendshape: the vertices that it moves. Sparse, since most shapes are local.
struct Shape {
  std::string name;                   ///< An ICT name, or "tongueOut".
  std::vector<std::uint32_t> vertex;  ///< Ascending.
  std::vector<Vec3f> delta_m;         ///< Displacement at weight 1, metres; beside `vertex`.
};

/// What a part of the mesh is made of; renderers choose the shading by it.
enum class Material : std::uint8_t {
  skin,
  lips,
  sclera,
  iris,
  pupil,
  cornea,
  teeth,
  gums,
  tongue,
  hair,     ///< Hair as one modelled piece.
  strands,  ///< Ribbons of hairs: uv.x counts them across, kStrandsPerUv a unit; uv.y is 0 at the root, 1 at
            ///< the tip.
  lash,
  mouth_inside,
  cloth,
  other
};

/// As in face::Material, for files and people: "mouth_inside".
[[nodiscard]] std::string_view material_name(Material material);

/// Hairs of Material::strands that lie beside each other in one unit of uv.x.
inline constexpr float kStrandsPerUv = 64;
/// A file's picture of strands is white where a hair is this many times its ribbon's colour, the brightest of
/// all.
inline constexpr float kBrightestStrand = 1.25F;

/// A part of the mesh with one material.
struct Part {
  std::string name;  ///< "skin", "eye_L", "teeth_upper", ...
  Material material = Material::skin;
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
};

/// An eyeball that turns: the vertices [first_vertex, first_vertex + vertex_count) about `centre_m`.
struct Eyeball {
  std::uint32_t first_vertex = 0;
  std::uint32_t vertex_count = 0;
  Vec3f centre_m = Vec3f::Zero();
};

/// A named set of vertices.
struct Region {
  std::string name;                   ///< "skin", "lips", "brow_L", "eye_R", ...
  std::vector<std::uint32_t> vertex;  ///< Ascending.
};

/// Whose mesh it is: what is known by vertex or by place on one of these is not known on another.
enum class Origin : std::uint8_t {
  builtin,  ///< Ours, of any identity, as make_builtin generates it: its sites are known by name.
  ict,      ///< ICT-FaceKit's 26,719 vertices in its order: rigs name sites by vertex.
  other,
};

/// A blendshape model, M(w) = B0 + sum_k w_k B_k. Metres; +X the performer's left, +Y up, +Z forward (frame
/// H).
struct Face {
  std::string name;  ///< "builtin", "ict", or the file's stem.
  Origin origin = Origin::other;
  std::vector<Vec3f> neutral_m;  ///< B0.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Part> parts;          ///< Cover all triangles in order; may be one part.
  std::vector<Eigen::Vector2f> uv;  ///< Empty, or beside neutral_m; strands read it as their Material says.
  std::vector<Vec3f> colour;        ///< Empty, or beside neutral_m: linear RGB albedo, 0 to 1.
  std::vector<Shape>
      shapes;  ///< Exactly one a name; in ICT order, missing ones with no vertices; tongueOut last if any.
  std::array<std::uint32_t, 68>
      landmarks{};  ///< Multi-PIE 68, vertex indices; 0 is on the performer's right.
  bool has_landmarks = false;
  std::vector<Region> regions;  ///< At least "skin": the vertices that pve_face_mm averages over.
  std::array<Eyeball, 2> eyes;  ///< Left, right; vertex_count 0 when unknown.

  [[nodiscard]] const Region* region(std::string_view region_name) const;
  [[nodiscard]] const Shape* find_shape(std::string_view shape_name) const;
  /// Of each vertex, whether a part of this material uses it.
  [[nodiscard]] std::vector<bool> vertices_of(Material material) const;
};

/// Writes M(w) into `vertices_m` (size of neutral_m). No allocation. Eyeballs do not turn here.
void evaluate(const Face& face, const BlendshapeWeights& weights, float tongue_out,
              std::span<Vec3f> vertices_m);

/// Where the eyes look as the eyeLook weights say, kEyeTurnRadPerUnit a unit: yaw to the performer's left and
/// pitch upwards, rad; left eye, right eye.
[[nodiscard]] std::array<Eigen::Vector2f, 2> eyes_rad(const BlendshapeWeights& weights);

/// Turns the eyeballs in place to there.
void turn_eyes(const Face& face, const BlendshapeWeights& weights, std::span<Vec3f> vertices_m);

/// Normals by Max's weights (normals.h), unit; shape as vertices_m.
void vertex_normals(const Face& face, std::span<const Vec3f> vertices_m, std::span<Vec3f> normals);

/// Where the shape moves most at weight 1: metres. 0 when the face lacks it.
[[nodiscard]] float peak_displacement_m(const Face& face, std::string_view shape_name);

}  // namespace mien::face
