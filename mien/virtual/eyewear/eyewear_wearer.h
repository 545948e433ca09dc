#pragma once

#include <cstddef>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/eyewear/eyewear_faults.h"

namespace mien::virt {

/// How the skin's reflectance varies over the face, fixed to the skin: a sum of waves over the neutral face.
class SkinPattern {
 public:
  SkinPattern(double relative, double size_m, Random random);
  /// A factor around 1, above 0. `neutral_m`: the spot of skin by its place on the neutral face, frame H.
  [[nodiscard]] double at(const Vec3& neutral_m) const;

 private:
  struct Wave {
    Vec3 turns_per_m;
    double phase = 0;  ///< Turns.
  };
  double relative_;
  std::vector<Wave> waves_;
};

/// A sensor where the glasses hold it. Frame H of the wearer's head.
struct SeatedSensor {
  Vec3 position_m = Vec3::Zero();
  Vec3 aim = Vec3::UnitZ();  ///< Unit.
};

/// How the glasses have moved against where they were fitted: turned about their centre, then shifted.
/// Frame H.
struct EyewearSeat {
  Vec3 shift_m = Vec3::Zero();
  Vec3 tilt_rad = Vec3::Zero();  ///< Rotation vector.
};

/// A person who wears the glasses.
struct EyewearWearer {
  face::Face face;
  double reflectance = 0.55;  ///< Of the skin at the LED's wavelength, mean over the face.
  SkinPattern pattern{0, 1, Random(0)};
  std::vector<SeatedSensor> sensors;  ///< Of the rig's, in its order, as the glasses were fitted.
  Vec3 centre_m = Vec3::Zero();       ///< Of the sensors: what tilts turn about.
};

/// Puts the rig's glasses onto a face. The frame keeps its size and shape: it is laid on by eyes, bridge of
/// the nose and temples (rigid), and then fitted as an optician does: a sensor nearer or farther from the
/// neutral skin than fit_mm is moved along its aim. Skin and pattern are drawn. Errors: not_found (a mount
/// without position_m or aim; a face without landmarks; a sensor that does not see skin).
[[nodiscard]] Result<EyewearWearer> seat_eyewear(face::Face face, const sensor::Rig& rig,
                                                 const EyewearFaults& faults, const Random& random);

/// The same on a random identity of the built-in face.
[[nodiscard]] Result<EyewearWearer> draw_eyewear_wearer(const sensor::Rig& rig, const EyewearFaults& faults,
                                                        const Random& random);

/// How the glasses sit when they are put on: shift and tilt up to the faults', in any direction.
[[nodiscard]] EyewearSeat draw_seat(const EyewearFaults& faults, Random& random);

/// The sensor with the glasses at `seat`.
[[nodiscard]] SeatedSensor seated(const EyewearWearer& wearer, std::size_t sensor, const EyewearSeat& seat);

}  // namespace mien::virt
