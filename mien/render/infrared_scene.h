#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/face/skin_marks.h"
#include "mien/render/lens.h"
#include "mien/render/raster.h"

namespace mien::render {

/// A light-emitting diode: frame H.
struct InfraredLamp {
  Vec3f position_m = Vec3f::Zero();
  Vec3f aim = -Vec3f::UnitZ();  ///< Unit.
  float intensity = 1;  ///< Straight ahead, W/sr; falls as the cosine off `aim` to the power `narrow`.
  float narrow = 1;
  float radius_m = 1.2e-3F;  ///< Of the part that shines: the size of its glint.
};

/// A thing beside the face that keeps light off and is seen: a hand, a cup, the frame of spectacles.
struct InfraredThing {
  std::size_t vertices = 0;                             ///< How many; their places come with each pose.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Of these; both sides are seen.
  float albedo = 0.3F;
  float shine = 0;  ///< Mirror reflection straight on, 0 to 1.
};

/// An eye as cameras beside it see it: a ball with a cornea before it (Gullstrand's schematic eye: the ball's
/// radius is 12 mm, the cornea's 7.8, its centre 5.6 mm before the ball's; here in proportion to the ball).
struct InfraredEye {
  float iris = 0.2F, sclera = 0.62F;  ///< Albedos.
  float fibres = 0.35F;               ///< Relative depth of the iris's pattern.
  float limbus_m = 5.9e-3F;           ///< Radius of the iris's rim.
  float person = 0;                   ///< Moves the pattern; one number an eye.
};

/// What is chosen once of a wearer.
struct InfraredWearer {
  face::SkinMarks marks;
  std::array<InfraredEye, 2> eyes;  ///< Left, right.
  /// The albedo (850 nm) at a place of the neutral, of what SurfacePaint gives; none: as it is.
  std::function<float(const Vec3f& neutral_m, face::Material material, float albedo)> repaint;
  std::vector<float> beard;  ///< Beside the face's vertices, or empty: how much of the skin is hair, 0 to 1.
  float beard_albedo = 0.1F;
  /// Of what is no face, a headset's inside, about: share of what white skin sends where the face is lit as
  /// it is on average. It varies smoothly.
  float background = 0;
  float lash_cover = 1;  ///< Factor on how much of a lash's or brow's ribbon is hair.
  std::vector<InfraredThing> things;
  /// Spectacles' glasses: discs that mirror lamps. None: no spectacles.
  struct Glass {
    Vec3f centre_m, forward;  ///< Unit; frame H.
    float radius_m = 0.023F;
    float curve_m = 0.13F;  ///< Radius of the front surface.
  };
  std::vector<Glass> glasses;
};

/// The front of a head in the infrared, lit by lamps close to it, for the pictures of many cameras close to
/// it. Reflectances are found once and kept by triangle; the light of the lamps is found at the vertices, by
/// rays in packets, once a pose; what a camera sees by rasterisation at four samples a pixel. Measured beside
/// rays one by one: mien bench headset.
///
/// The same calls give the same bits. pose() and light() exclude draw(); draw() may run on several threads.
class InfraredScene {
 public:
  /// Keeps what lies within `reach_m` of one of `cameras_m` on the neutral. `face` outlives it. Its colours
  /// are those of 850 nm (builtin_face::paint_infrared), or it has none.
  InfraredScene(const face::Face& face, InfraredWearer wearer, std::span<const Vec3f> cameras_m,
                float reach_m = 0.11F);
  ~InfraredScene();
  InfraredScene(InfraredScene&&) noexcept;

  /// The face when the first row of a picture is exposed, and when the last one is. Shapes: the face's
  /// vertices, with eyes turned; `things_m`: those of all things, in their order.
  void pose(std::span<const Vec3f> first_m, std::span<const Vec3f> last_m, std::span<const Vec3f> things_m);
  /// Pupils' radii in metres, left and right.
  void set_pupils(const std::array<float, 2>& radius_m);
  /// The lamps' light on the pose, and a little from everywhere: `ambient`, W/m^2. Found where one of these
  /// cameras may see it: others show it dark.
  void light(std::span<const InfraredLamp> lamps, float ambient, std::span<const Lens> seen_by);

  /// Memory for one picture at a time.
  class Canvas {
   public:
    Canvas();
    ~Canvas();
    Canvas(Canvas&&) noexcept;

   private:
    friend class InfraredScene;
    struct State;
    std::unique_ptr<State> state_;
  };
  /// The radiance (W/m^2/sr) that each pixel gets, row by row; `out` has width x height. `exposure`: how long
  /// a row is exposed, as a share of the time between the first row and the last.
  void draw(const Lens& lens, float exposure, Canvas& canvas, std::span<float> out) const;

  /// The same picture, of which what is seen is found by a ray through each sample, one after the other.
  /// Slow: for tests and benchmarks, without motion and hair.
  void draw_by_rays(const Lens& lens, std::span<float> out) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mien::render
