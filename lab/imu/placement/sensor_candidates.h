#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_motion.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::lab {

/// A place on the skin where an IMU might be glued.
struct SensorCandidate {
  std::string name;                ///< Unique among candidates: "zygomaticus_2_L", "cheek_07_R".
  std::string area;                ///< The muscle or the part of the face: "frontalis", "cheek".
  char side = 'M';                 ///< 'L', 'R' (the performer's own) or 'M'.
  Vec3 position_m = Vec3::Zero();  ///< On the built-in head, frame H.
  int ict_vertex = -1;             ///< Site on the ICT mesh; -1 where nobody knows it.
  bool operator==(const SensorCandidate&) const = default;
};

/// What a module covers: two candidates closer than this cannot both be used, and one within half of it of
/// lids, lips, ears, brows or hair cannot be glued.
inline constexpr double kModuleApartM = 0.012;

/// An even grid over the built-in head's skin where something can be glued: face and temples from the
/// hairline to the edge of the jaw; not lids, lips, brows, nostrils, ears, scalp and neck. Neighbours are
/// between `spacing_m` (0.003 to 0.05) and twice that apart. The left half is the right one's mirror image,
/// candidate by candidate (the next one in the list); those of the midline come first. Cost: a second or two.
[[nodiscard]] std::vector<SensorCandidate> dense_candidates(double spacing_m);

/// The IMUs of a rig that are on the face. Errors, by the sensor's name: not_found (no place), out_of_range
/// (off the skin, inside the head), bad_usage (none, two at one site).
[[nodiscard]] Result<std::vector<SensorCandidate>> candidates_of(const sensor::Rig& rig);

/// The candidates as sensors of a rig's role "face", in their order, and nothing else: what
/// virt::skin_sites() takes. No device, no head sensor.
[[nodiscard]] sensor::Rig sites_rig(const std::vector<SensorCandidate>& candidates);

/// The candidate at the mirrored place within 3 mm, by index; itself on the midline, `candidates.size()`
/// where there is none.
[[nodiscard]] std::vector<std::size_t> mirror_candidates(const std::vector<SensorCandidate>& candidates);

/// A rig of these candidates and of the head sensor of `base`, which is its reference, with the faults of
/// `base`. Devices are the virtual nodes of `mien perform --to`, from 0 on; places are rounded to a tenth of
/// a millimetre. Its [skin] keeps headings from drifting. Errors: not_found (`base` has no head sensor),
/// bad_usage (no candidate), those of study_skin_motion().
[[nodiscard]] Result<sensor::Rig> worn_rig_of(const std::vector<SensorCandidate>& candidates,
                                              const sensor::Rig& base, const std::string& name,
                                              const virt::SkinMotionRequest& skin, const Progress& progress);

}  // namespace mien::lab
