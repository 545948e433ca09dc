#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "mien/core/smoothstep.h"
#include "mien/render/error_colours.h"
#include "mien/render/hair_fragments.h"
#include "mien/render/parallel.h"
#include "mien/render/raster.h"
#include "mien/render/ray_scene.h"
#include "mien/render/renderer.h"
#include "mien/render/strands.h"
#include "mien/render/surface_paint.h"
#include "mien/render/tone.h"
#include "mien/render/wrinkles.h"

// What the renderer's sources share: its state. What is found once of a face: renderer_state.cpp; lighting of
// vertices: light_vertices.cpp; of hair: shade_hair.cpp; of a place seen: shade.cpp; the picture:
// renderer.cpp.
namespace mien::render {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr std::size_t kLights = 3;
/// Nothing of a head is further away than this.
inline constexpr float kFar_m = 0.5F;
/// What is nearer than this shades the light from everywhere.
inline constexpr float kAmbientReach_m = 0.07F;
/// Directions that are asked of a vertex at most: from everywhere, and to one light.
inline constexpr std::size_t kMostDirections = 96, kMostLightSamples = 16;
/// Light from everywhere that comes flatter than this (cosine) is left out.
inline constexpr float kGrazing = 0.02F;
/// Skin to which less comes than this share of the light, from everywhere and from each lamp, is covered.
inline constexpr float kCoveredLight = 0.06F;
/// Rings of covered vertices that their neighbours lend light to.
inline constexpr int kCoveredRings = 2;
/// Steps in which light spreads along the skin.
inline constexpr int kScatterSteps = 6;

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
  Vec3f sky = Vec3f::Zero(), ground = Vec3f::Zero();
  Vec3f background_top = Vec3f::Zero(), background_bottom = Vec3f::Zero();  // Linear.

  /// Light that comes from a direction where nothing stands in the way.
  [[nodiscard]] Vec3f around(const Vec3f& direction) const {
    return mix(ground, sky, smoothstep(-0.9F, 0.9F, direction.y()));
  }
};

/// Light that arrives at a vertex: from everywhere (over pi), and of each light the part that arrives, all by
/// channel.
using VertexLight = Eigen::Array<float, 3 * (1 + kLights), 1>;
[[nodiscard]] inline Vec3f ambient_of(const VertexLight& light) {
  return light.head<3>().matrix();
}
[[nodiscard]] inline Vec3f visible_of(const VertexLight& light, std::size_t l) {
  return light.segment<3>(3 * (1 + static_cast<Eigen::Index>(l))).matrix();
}

/// A face ready to be lit, and the picture at work. Frame H, metres.
struct Renderer::State {
  using Material = face::Material;
  using Triangle = std::array<std::uint32_t, 3>;

  class TilePainter;

  /// A place of a triangle that the camera sees.
  struct SeenPlace {
    std::uint32_t triangle = 0;        // Of the face.
    std::array<float, 3> weight{};     // Of its corners.
    Vec3f to_camera = Vec3f::UnitZ();  // Unit.
  };

  State(const face::Face& f, Quality q, int thread_count, const face::SkinFolds& skin_folds,
        const face::SkinMarks& marks);

  // Once, of the face.
  [[nodiscard]] std::vector<Triangle> triangles_of(std::span<const std::uint32_t> which) const;
  void find_still_hair();
  void find_twins();
  void find_neighbours();
  void find_vertices_between();
  /// Places in lit_vertex of those that share an edge with the one at place `k`.
  [[nodiscard]] std::span<const std::uint32_t> neighbours_of(std::size_t k) const {
    return std::span(neighbour).subspan(neighbour_start[k], neighbour_start[k + 1] - neighbour_start[k]);
  }
  void measure_lashes();

  // Of a pose.
  /// Whether no hair that keeps its shape has moved: its light is then that of the neutral, found once.
  [[nodiscard]] bool hair_rests(std::span<const Vec3f> vertices_m) const;
  /// Takes over positions; with `all` those of hair that keeps its shape as well.
  void pose(std::span<const Vec3f> vertices_m, bool all);
  void find_normals(bool all);
  void shade_by_hair();
  [[nodiscard]] VertexLight light_at(std::uint32_t vertex) const;
  /// Light on all but hair, scattered in skin: found anew at these places of lit_vertex, at the others as it
  /// was.
  void light_surfaces(const std::vector<std::uint32_t>& places);
  /// Skin that an ear or a collar covers gets hardly any light, and would darken what is seen beside its
  /// cover: it takes that of its neighbours.
  void lend_to_covered();
  /// What a film of a head that keeps still finds once: the light of the neutral.
  void light_rest();
  /// Where a pose can change the light of the neutral visibly: places of lit_vertex.
  [[nodiscard]] std::vector<std::uint32_t> places_to_light() const;
  void find_what_rests();
  /// Of tiles in which something may move: what is seen there, and by that which vertices' light is.
  void see_what_moves();
  /// Of one tile the nearest of what keeps light off.
  void see(std::size_t tile, TileDepths* depths) const;
  [[nodiscard]] std::size_t triangles_in(std::size_t tile) const;
  /// Whether a tile shows what it showed of the neutral.
  [[nodiscard]] bool tile_rests(std::size_t tile) const;
  void find_vertices_near_motion();
  void light_hair(const std::vector<std::uint32_t>& vertices);
  /// Twins have the same light.
  void copy_light(bool all);

  // Of a picture.
  void set_studio(const Camera& new_camera, const Look& new_look);
  /// A still is drawn so many times larger each way, and made smaller.
  [[nodiscard]] int fineness() const { return quality == Quality::still ? 2 : 1; }
  /// As many pictures as `errors`, each in the face's own colours or by errors.
  void draw(std::span<const ErrorColours* const> errors, std::span<Image> pictures);
  /// x, y: pixels of the picture; linear.
  [[nodiscard]] Vec3f background(float x, float y) const;
  /// Light as the picture shows it, linear: its tone, grey where the look is infrared.
  [[nodiscard]] Vec3f developed(const Vec3f& arriving) const;
  /// What hair sends to the camera, in its own colour or, in a picture of errors, that of no error.
  struct HairLight {
    std::vector<Vec3f> tint, gloss;  // Beside the vertices: with a hair's brightness, and without.
    std::vector<TileHair> still;     // Of a film: hair that keeps its shape, while it rests.
    std::vector<std::vector<std::uint8_t>>
        tile;  // The same of tiles in which all rests: bytes of their pixels.
    bool still_known = false;
    bool moving_known = false;
  };
  void shade_hair(bool in_error_colours);
  /// Of one vertex: what grows with a hair's brightness and what does not.
  void shade_strand(std::uint32_t vertex, const Vec3f& along, const Vec3f& albedo, Vec3f* tint,
                    Vec3f* gloss) const;
  void gather_hair(std::span<const std::uint32_t> triangles, const HairLight& light, int left, int top,
                   TileHair* hair) const;
  [[nodiscard]] Vec3f shade(const SeenPlace& seen, const SeenPlace* glass, const ErrorColours* errors) const;
  /// How much of a bust is there: it ends softly instead of with a cut.
  [[nodiscard]] float cover_at(const SeenPlace& seen) const;
  [[nodiscard]] Vec3f shade_eye(const Vec3f& p, Vec3f n, const Vec3f& to_camera, const Surface& surface,
                                const Vec3f& neutral, bool painted) const;
  [[nodiscard]] Vec3f mirrored(const Vec3f& p, const Vec3f& n, const Vec3f& to_camera, float sharpness) const;

  template <class Value>
  [[nodiscard]] Value between(const SeenPlace& seen, const std::vector<Value>& field) const {
    const auto& [a, b, c] = face.triangles[seen.triangle];
    return seen.weight[0] * field[a] + seen.weight[1] * field[b] + seen.weight[2] * field[c];
  }

  const face::Face& face;
  Quality quality;
  Workers workers;
  SurfacePaint paint;
  Wrinkles wrinkles;
  Vec3f middle_m;                  // Inside the head.
  std::vector<Material> material;  // A triangle.
  // Triangles: what keeps light off, what is clear before it, and hair and lashes, which let some light
  // through; of these what no shape moves.
  std::vector<std::uint32_t> solid_triangle, clear_triangle, hair_triangle;
  std::vector<std::uint32_t> moving_hair_triangle, still_hair_triangle;
  std::vector<bool> is_strand;              // A vertex of a ribbon of hair.
  std::vector<bool> in_mouth;               // A vertex of teeth, gums or tongue.
  std::vector<bool> is_still;               // A vertex of hair that no shape moves.
  std::vector<std::uint32_t> still_vertex;  // These.
  std::vector<std::uint32_t> twin;          // The first vertex at the same place with about the same normal.
  std::vector<std::uint32_t> lit_vertex;    // Neither eye, clear nor hair; its own twin.
  std::vector<std::uint32_t> moving_hair_vertex;  // Its own twin.
  std::vector<std::uint32_t> still_hair_vertex;
  std::vector<std::uint32_t> copied_vertex;  // Not its own twin, and not still.
  std::vector<std::uint32_t> every_place;    // 0 to lit_vertex.size().
  std::vector<bool> near_motion;             // A vertex that shapes move, or what is close to it.
  std::vector<std::uint32_t> neighbour_start,
      neighbour;                          // Beside lit_vertex, by place in it: who shares an edge.
  std::vector<std::uint8_t> is_between;   // Beside lit_vertex: 1 where a film lights only the neighbours.
  std::vector<VertexLight> spread_share;  // Beside lit_vertex: how much a step of scattering takes over.
  std::vector<float> lash_length_m;       // From the lid; 0 elsewhere.
  float lowest_m = 0;
  std::vector<Vec3f> ambient_directions, eye_directions;
  RayScene solid, hair;

  // Of the pose that was lit last.
  Camera camera;
  Look look;
  Studio studio;
  Projection view;
  bool is_set = false;       // A camera and a look are.
  bool rest_is_lit = false;  // `rest` is known, and the pose stands on it.
  struct Rest {
    std::vector<VertexLight> unscattered;        // Beside lit_vertex.
    std::vector<VertexLight> light;              // Beside the vertices.
    std::vector<Vec3f> normal;                   // Beside the vertices.
    std::vector<Wrinkles::Slopes> folds;         // The same.
    std::vector<std::size_t> triangles_in_tile;  // All that may be seen there.
  };
  Rest rest;
  std::vector<TileDepths> tile_depths;  // Beside the tiles, where is_seen is 1.
  std::vector<std::uint8_t> is_seen;
  std::vector<std::uint8_t> is_visible;  // Beside the vertices, of their own twin.
  std::vector<std::uint8_t> rests;  // Beside the vertices: 1 where place, normal and light are the neutral's.
  std::vector<Vec3f> position, normal;
  std::vector<Wrinkles::Slopes> folds;  // Beside the vertices; empty where the face has none.
  std::vector<ScreenPoint> on_screen;
  TileBins solid_bins, clear_bins, moving_hair_bins, still_hair_bins;
  std::vector<Vec3f> around_direction;  // Beside ambient_directions: Studio::around() of each.
  std::vector<VertexLight> light;
  std::vector<VertexLight> unscattered, scattered, scattered_next;  // Beside lit_vertex.
  std::array<Eigen::Matrix3f, 2> eye_turn;
  struct HairShade {
    std::array<std::uint32_t, kMostDirections / 32>
        ambient{};  // A bit for each direction that hair stands in.
    std::array<std::uint16_t, kLights> light{};
  };
  std::vector<HairShade> hair_shade;    // Beside the vertices.
  std::array<HairLight, 2> hair_light;  // In hair's own colour, and in a picture of errors.
};

}  // namespace mien::render
