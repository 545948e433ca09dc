#pragma once

#include <memory>
#include <span>

#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/face/skin_marks.h"
#include "mien/render/camera.h"
#include "mien/render/image.h"

namespace mien::render {

/// How much work goes into a picture.
enum class Quality {
  video,  ///< 4 samples a pixel, shaded once for each surface; keeps from frame to frame what rests.
  still,  ///< 16 samples a pixel, shaded at 4 places or more, finer shadows.
};

/// Light and background. Lights stand with the camera, as in a studio: left, right and up are the picture's.
struct Look {
  /// A soft light on a disc far away.
  struct Light {
    Vec3f direction = Vec3f::UnitZ();  ///< Towards the light: +x right, +y up, +z to the camera.
    Vec3f radiance = Vec3f::Zero();    ///< Linear RGB; what a white wall facing it would show.
    float radius_rad = 0.2F;           ///< Half the angle that it fills; larger softens its shadows.
    bool operator==(const Light&) const = default;
  };
  Light key;                     ///< Warm, from above and the side.
  Light fill;                    ///< Lifts the other side.
  Light rim;                     ///< From behind: parts the head from the background.
  Vec3f sky = Vec3f::Zero();     ///< Light from everywhere above, linear RGB.
  Vec3f ground = Vec3f::Zero();  ///< The same from below.
  Rgb background_top = {0, 0, 0};
  Rgb background_bottom = {0, 0, 0};
  /// Infrared light: the picture is grey, the red channel's light, whose way under the skin is nearest to it.
  /// The face's colours are to be those that it has there (builtin_face::paint_infrared).
  bool infrared = false;

  bool operator==(const Look&) const = default;

  [[nodiscard]] static Look dark();
  [[nodiscard]] static Look light();
};

/// Paints the error of each vertex on the face instead of its own colours.
struct ErrorColours {
  std::span<const float> error_m;  ///< Beside the vertices; >= 0.
  float full_scale_m = 5e-3F;      ///< Where the ramp ends.
};

/// Draws one face. What is seen is found by rasterisation in tiles, hair sorted by depth in each pixel; the
/// part of each light that arrives is found by rays at the vertices and diffused along the skin, red
/// furthest; eyes are wet. The same input gives the same bytes whatever the number of threads and whatever
/// was drawn before. A film of a head that does not turn lights hair, and all that is far from what moves,
/// once. One picture at a time: not thread-safe.
class Renderer {
 public:
  /// `face` outlives the renderer; triangles and shapes do not change meanwhile. `threads` 0: one a core.
  /// `folds`: how its skin wrinkles (builtin_face::skin_folds); smooth unless told.
  /// `marks`: its freckles, moles and stubble (builtin_face::skin_marks); none unless told.
  explicit Renderer(const face::Face& face, Quality quality = Quality::still, int threads = 0,
                    const face::SkinFolds& folds = {}, const face::SkinMarks& marks = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// One picture of the face in this pose. Shape: vertices_m beside the face's neutral, finite.
  /// Cost: on two cores 640 x 640 in about a second as a still; the ray trees are refitted, not rebuilt.
  [[nodiscard]] Image still(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look,
                            const ErrorColours* errors = nullptr);

  /// The same in two steps, for several pictures of one pose: the light on it, which is about half of the
  /// work, ...
  void light(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look);
  /// ... and a picture of what was lit last, by the camera and look of then.
  [[nodiscard]] Image draw(const ErrorColours* errors = nullptr);
  /// ... or two, of which what is seen where is found once.
  struct Pictures {
    Image plain, errors;
  };
  [[nodiscard]] Pictures draw_with_errors(const ErrorColours& errors);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mien::render
