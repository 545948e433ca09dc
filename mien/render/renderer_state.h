#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <thread>
#include <vector>

#include "mien/core/smoothstep.h"
#include "mien/render/error_colours.h"
#include "mien/render/ray_scene.h"
#include "mien/render/renderer.h"
#include "mien/render/strands.h"
#include "mien/render/surface_paint.h"
#include "mien/render/tone.h"

// What the renderer's sources share: its state. Lighting of vertices: light_vertices.cpp;
// of a ray's end: shade.cpp; the picture: renderer.cpp.
namespace mien::render {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr std::size_t kLights = 3;
/// Nothing of a head is further away than this.
inline constexpr float kFar_m = 0.5F;
/// What is nearer than this shades the light from everywhere.
inline constexpr float kAmbientReach_m = 0.07F;

[[nodiscard]] inline bool is_eye(face::Material material) {
  using face::Material;
  return material == Material::sclera || material == Material::iris || material == Material::pupil;
}

/// `count` directions spread evenly over the sphere (Fibonacci lattice).
[[nodiscard]] std::vector<Vec3f> sphere_directions(int count);

/// Lights as one picture sees them, frame H.
struct Studio {
  std::array<Look::Light, kLights> light;
  std::array<std::vector<Vec3f>, kLights> light_samples;
  Vec3f sky, ground;

  /// Light that comes from a direction where nothing stands in the way.
  [[nodiscard]] Vec3f around(const Vec3f& direction) const {
    return mix(ground, sky, smoothstep(-0.9F, 0.9F, direction.y()));
  }
};

/// A face ready to be lit, and the picture at work. Frame H, metres.
struct Renderer::State {
  using Material = face::Material;
  using Triangle = std::array<std::uint32_t, 3>;

  State(const face::Face& f, Quality q, int thread_count)
      : face(f),
        quality(q),
        threads(thread_count > 0 ? thread_count
                                 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
        paint(f),
        is_strand(f.vertices_of(Material::strands)),
        middle_m(middle_of_head_m(f)),
        material(material_of_triangles(f)),
        layer(layer_of_triangles()),
        solid(f.neutral_m, pick_triangles(Layer::solid, &solid_triangle)),
        clear(f.neutral_m, pick_triangles(Layer::clear, &clear_triangle)),
        fringe(f.neutral_m, pick_triangles(Layer::fringe, &fringe_triangle)),
        hair(f.neutral_m, strand_triangles()) {
    find_neighbours();
    measure_lashes();
    lowest_m = std::numeric_limits<float>::max();
    for (const Vec3f& p : f.neutral_m) lowest_m = std::min(lowest_m, p.y());
    ambient_directions = sphere_directions(q == Quality::still ? 96 : 40);
    eye_directions = sphere_directions(q == Quality::still ? 48 : 24);
  }

  static std::vector<Material> material_of_triangles(const face::Face& f) {
    std::vector<Material> all(f.triangles.size(), Material::skin);
    for (const face::Part& part : f.parts)
      for (std::size_t t = part.first_triangle; t < std::size_t{part.first_triangle} + part.triangle_count;
           ++t)
        if (t < all.size())
          // Without texture coordinates nobody knows where on a ribbon hairs are: then it is hair as one
          // piece.
          all[t] = part.material == Material::strands && f.uv.empty() ? Material::hair : part.material;
    return all;
  }

  /// Rays from the camera meet three meshes: what is solid, what is clear, and hair and lashes, of which each
  /// lets some light through. Light is kept off by what is solid, and in part by strands.
  enum class Layer : std::uint8_t { solid, clear, fringe };

  [[nodiscard]] std::vector<Layer> layer_of_triangles() const {
    std::vector<Layer> all;
    for (const Material m : material)
      all.push_back(m == Material::cornea                           ? Layer::clear
                    : m == Material::lash || m == Material::strands ? Layer::fringe
                                                                    : Layer::solid);
    return all;
  }
  [[nodiscard]] std::vector<Triangle> strand_triangles() const {
    std::vector<Triangle> picked;
    for (std::size_t t = 0; t < face.triangles.size(); ++t)
      if (material[t] == Material::strands) picked.push_back(face.triangles[t]);
    return picked;
  }
  [[nodiscard]] std::vector<Triangle> pick_triangles(Layer wanted, std::vector<std::uint32_t>* index) const {
    std::vector<Triangle> picked;
    for (std::size_t t = 0; t < face.triangles.size(); ++t)
      if (layer[t] == wanted) {
        picked.push_back(face.triangles[t]);
        index->push_back(static_cast<std::uint32_t>(t));
      }
    return picked;
  }

  void find_neighbours();
  void measure_lashes();
  void find_normals(std::span<const Vec3f> vertices_m);
  void light_vertices(const Studio& studio);
  void scatter_light();
  [[nodiscard]] Vec3f shade(const Studio& studio, const Vec3f& origin, const Vec3f& direction,
                            const ErrorColours* errors, float footprint_m, float* cover) const;
  /// Light from the hair and lashes that stand before `distance`; `through` becomes what they let through.
  [[nodiscard]] Vec3f shade_fringe(const Studio& studio, const Vec3f& origin, const Vec3f& direction,
                                   float distance, bool in_error_colours, float footprint_m,
                                   float* through) const;
  [[nodiscard]] Vec3f shade_eye(const Studio& studio, const Vec3f& p, Vec3f n, const Vec3f& to_camera,
                                const Surface& surface, const Vec3f& neutral, bool painted) const;
  [[nodiscard]] Vec3f mirrored(const Studio& studio, const Vec3f& p, const Vec3f& n, const Vec3f& to_camera,
                               float sharpness) const;

  const face::Face& face;
  Quality quality;
  int threads;
  SurfacePaint paint;
  std::vector<bool> is_strand;     // A vertex of a ribbon of hair.
  Vec3f middle_m;                  // Inside the head.
  std::vector<Material> material;  // A triangle.
  std::vector<Layer> layer;
  std::vector<std::uint32_t> solid_triangle, clear_triangle, fringe_triangle;  // Index in the face.
  RayScene solid, clear, fringe, hair;
  bool has_hair = false;                                  // That keeps light off.
  std::vector<bool> scatters;                             // A vertex of skin or lips.
  std::vector<std::uint32_t> neighbour_start, neighbour;  // Vertices that share an edge.
  std::vector<std::uint32_t> twin;   // The first vertex at the same place with about the same normal.
  std::vector<float> spread_m;       // Mean edge length at each vertex.
  std::vector<bool> lit_by_vertex;   // Neither eye nor clear.
  std::vector<float> lash_length_m;  // From the lid; 0 elsewhere.
  float lowest_m = 0;
  std::vector<Vec3f> ambient_directions, eye_directions;

  // Of the pose that was lit last.
  struct Setting {
    Camera camera;
    Studio studio;
    Vec3f background_top = Vec3f::Zero(), background_bottom = Vec3f::Zero();  // Linear.
    bool infrared = false;
  };
  Setting setting;
  std::vector<Vec3f> position, normal;
  std::vector<Vec3f> ambient;                       // Light from everywhere that arrives, over pi.
  std::array<std::vector<Vec3f>, kLights> visible;  // Part of each light that arrives, by channel.
  std::array<Eigen::Matrix3f, 2> eye_turn;
};

}  // namespace mien::render
