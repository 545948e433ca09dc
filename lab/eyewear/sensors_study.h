#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lab/eyewear/marker_errors.h"
#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// Between training and tests, s.
inline constexpr double kRestS = 60;

/// The protocol of Asano et al. 2017, section 5.1; the defaults are the paper's.
struct SensorsRequest {
  int wearers = 3;
  int poses = 600;             ///< Target poses of the training, of six components.
  double pose_s = 3;           ///< Each is on the screen for this long.
  std::size_t samples = 5000;  ///< Drawn from the training.
  double test_s = 10;          ///< Each of the nineteen tests.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// One wearer's training.
struct SensorsTraining {
  std::size_t samples = 0;
  std::size_t outliers = 0;  ///< Rejected of these, beyond four standard deviations.
  double share = 0;          ///< Of the markers' variance, that 20 components hold.
};

struct SensorsStudy {
  std::vector<std::string> markers;  ///< Names.
  std::vector<SensorsTraining> training;
  SensorsMethod faithful;    ///< All sensors.
  SensorsMethod faithful16;  ///< Without those on the ear hooks.
  SensorsMethod mean_pose;   ///< The training's mean: knowing nothing.
  /// The first wearer's error over all markers, sample by sample through the tests, mm; and when, s.
  std::vector<double> curve_s;
  std::vector<double> curve_mm;
};

/// Sensors on the ear hooks, by their sites "jaw_joint" and "lower_jaw".
[[nodiscard]] std::vector<std::uint16_t> ear_hook_sensors(const sensor::Rig& rig);

/// Each wearer puts the glasses on once, follows the target poses while sensors and motion capture record,
/// and then makes the tests with the glasses still on. The published method is fitted to what was captured,
/// and measured against where the markers truly are. Wearers are virtual ones of the built-in family; faults
/// are the rig's. The same request gives the same numbers, whatever the number of threads. Errors: those of
/// rig, faults and fit; bad_usage (fewer than one wearer, pose or the samples that a fit needs); cancelled.
/// Cost: about a minute of one core a wearer.
[[nodiscard]] Result<SensorsStudy> study_sensors(const SensorsRequest& request, const sensor::Rig& rig,
                                                 const builtin_face::MarkerSet& markers,
                                                 const Progress& progress);

}  // namespace mien::lab
