#pragma once

#include <algorithm>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// Linear diffuse reflectances (0 to 1) of one person's tissues, by which `paint` colours a head. Red, green
/// and blue of visible light; of one infrared wavelength all three are equal.
struct Albedos {
  Vec3f skin;
  Vec3f flush;  ///< Skin that blood shows through: cheeks, nose, chin, ears.
  Vec3f lips;   ///< The red of the lips.
  Vec3f mouth;  ///< Deep inside.
  Vec3f wet;    ///< Pink of the lids' inside.
  Vec3f nostril;
  Vec3f hair, brow, lash;
  Vec3f iris, pupil, sclera, sclera_corner, caruncle;
  Vec3f teeth, gums, tongue, cloth;
  float eye_shadow = 0.72F;  ///< Factor on the thin skin about the eyes.
};

/// From a to b as t goes from 0 to 1, held to these.
[[nodiscard]] inline Vec3f blend(const Vec3f& a, const Vec3f& b, double t) {
  return a + static_cast<float>(std::clamp(t, 0.0, 1.0)) * (b - a);
}

/// In visible light.
[[nodiscard]] Albedos visible_albedos(const BuiltinParameters& parameters);

/// At 850 nm, where melanin and blood absorb little: skin is bright and even, deep skin hardly darker than
/// fair, lips faint, irises grey whatever their colour, pupils dark; hair goes by its pigment.
[[nodiscard]] Albedos infrared_albedos(const BuiltinParameters& parameters);

}  // namespace mien::builtin_face
