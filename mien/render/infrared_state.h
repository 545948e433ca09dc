#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/render/infrared_scene.h"
#include "mien/render/ray_scene.h"

// What the infrared scene's sources share. Found once and of a pose: infrared_scene.cpp; of a picture:
// infrared_draw.cpp; what an eye does: infrared_eye.cpp.
namespace mien::render {

/// An eyeball where it is now, and what falls onto it.
struct SeenEye {
  Vec3f centre_m = Vec3f::Zero();
  Vec3f axis = Vec3f::UnitZ();  ///< Unit, through the pupil.
  Vec3f up = Vec3f::UnitY();    ///< Unit, at right angles to it; turns the iris's pattern.
  float radius_m = 0.012F;      ///< Of the ball.
  float pupil_m = 0.002F;       ///< Radius.
};

/// What the surface gets: the sum of the lamps' irradiances, each along its direction, W/m^2, and what comes
/// from everywhere.
struct FallingLight {
  Vec3f directed = Vec3f::Zero();  ///< Towards the lamps.
  float ambient = 0;
};

/// The radiance that a camera at `from_m` gets along `view` (unit) of an eye whose ball it meets at `ball_m`.
/// The iris is seen through the cornea, which bends the view and mirrors every lamp. `spread_m`: half the
/// width of what a sample stands for there; a glint is not smaller than that.
[[nodiscard]] float eye_radiance(const InfraredEye& look, const SeenEye& eye, const Vec3f& from_m,
                                 const Vec3f& view, const Vec3f& ball_m, const FallingLight& light,
                                 std::span<const InfraredLamp> lamps, float spread_m);

/// A mirror image of the lamps at p_m, seen along `view` of a surface with this normal that mirrors `share`
/// of the light straight on: radiance. `spread_rad`: half the angle over which the mirrored
/// direction is spread.
[[nodiscard]] float mirrored_lamps(std::span<const InfraredLamp> lamps, const Vec3f& p_m, const Vec3f& normal,
                                   const Vec3f& view, float share, float spread_rad);

/// Irradiance of a lamp at a place that faces it, W/m^2.
[[nodiscard]] float lamp_irradiance(const InfraredLamp& lamp, const Vec3f& p_m);

/// How a surface mirrors; what an eye does is eye_radiance's.
enum class Gloss : std::uint8_t { skin, lips, wet, teeth, thing, eye };

/// A triangle as it is shaded.
struct Facet {
  std::uint32_t first_texel = 0;  ///< Its albedos lie in rows along its sides.
  std::uint8_t steps = 1;         ///< Texels of a side, less one.
  Gloss gloss = Gloss::skin;
  std::uint8_t index = 0;  ///< Of the eye, or of the thing.
  bool two_sided = false;
};

struct InfraredScene::State {
  State(const face::Face& f, InfraredWearer w, std::span<const Vec3f> cameras_m, float reach_m);

  void bake(std::span<const std::uint32_t> of_face);
  void find_normals();
  void find_eyes(std::span<const Vec3f> vertices_m, std::array<SeenEye, 2>& eyes) const;
  /// Finds the vertices whose shadows are found by rays, such that each other one has one of them beside it.
  void find_shadow_vertices();
  [[nodiscard]] std::span<const std::uint32_t> shadows_of(std::uint32_t vertex) const {
    return std::span(shadow_of).subspan(shadow_start[vertex],
                                        shadow_start[vertex + 1] - shadow_start[vertex]);
  }
  /// Of a lamp at `lamp_m` that would give this at the seen vertices: `arriving`, where it matters.
  void ask_shadows(const Vec3f& lamp_m, std::span<const float> would_fall);
  /// The albedo of a facet where its second and third corner have these weights.
  [[nodiscard]] float albedo(const Facet& facet, float second, float third) const;
  /// Radiance that a camera at `from_m` gets of a place of a facet; `spread_m`: half of what a sample spans.
  [[nodiscard]] float shade(std::uint32_t facet, const std::array<float, 3>& weight, const Vec3f& from_m,
                            float row_time, float spread_m) const;

  /// What a pixel gets where no face is.
  [[nodiscard]] float background(const Lens& lens, float x, float y) const;

  const face::Face& face;
  InfraredWearer wearer;
  std::vector<std::uint32_t> kept;                     // Vertices of the face; those of the things follow.
  std::vector<std::array<std::uint32_t, 3>> triangle;  // Solid, of the kept.
  std::vector<Facet> facet;                            // Beside them.
  std::vector<std::uint8_t> texel;                     // Albedos, 255 is 1.
  std::vector<std::array<std::uint32_t, 3>> strand;    // Ribbons of lashes and brows.
  std::vector<Eigen::Vector2f> uv;                     // Beside the kept, of ribbons.
  std::vector<float> strand_albedo;                    // Beside the kept.
  std::array<Vec3f, 2> neutral_axis;                   // Of the eyes.
  // Beside the kept: of a vertex the ones that tell its shadow, itself alone where rays are sent to it.
  std::vector<std::uint32_t> shadow_start, shadow_of;
  std::vector<std::uint8_t> is_strand;  // Beside the kept.

  RayScene solid;
  // Of the pose.
  bool moves = false;
  std::vector<Vec3f> first, last, normal;  // Beside the kept.
  struct Coordinates {
    std::vector<float> x, y, z;
    void assign(std::span<const Vec3f> places_m);
  };
  Coordinates first_m, last_m;  // The same, for Lens::project().
  std::array<SeenEye, 2> first_eyes, last_eyes;
  // Of the light.
  std::vector<InfraredLamp> lamps;
  std::vector<FallingLight> light;  // Beside the kept.
  float background_radiance = 0;
  // Memory of light().
  std::vector<std::uint32_t> seen, asked;
  std::vector<ScreenPoint> points;
  std::vector<std::uint8_t> is_seen;
  std::vector<float> asked_of, arrived_of;  // Beside `seen`: of the lamps that rays are sent to.
  std::vector<float> falling;               // Beside `seen`, lamp by lamp: what would fall without shadows.
  std::vector<float> arriving;  // Beside the kept, of one lamp: which share arrives; below 0: not asked.
  std::vector<Vec3f> targets;
  std::vector<std::uint8_t> is_blocked;
};

}  // namespace mien::render
