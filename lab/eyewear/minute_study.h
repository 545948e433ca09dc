#pragma once

#include <optional>
#include <vector>

#include "lab/eyewear/sensors_study.h"
#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/eyewear/marker_network.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// What a minute of a wearer's own is worth: the same wearers, glasses, seats and tests as study_sensors(),
/// but instead of half an hour of poses under motion capture ten seconds of neutral and fifty of a range of
/// motion without any, and then a minute of rest. Every frame of 60 Hz counts, at its own time.
struct MinuteStudy {
  /// "neutral": the wearer's neutral markers, whatever the sensors say; "linear": the published model fitted
  /// to the minute, under motion capture; "learned": the network; "learned16": without the ear hooks.
  std::vector<SensorsMethod> methods;
  /// The network under other conditions: "remounted" (2 mm off, nothing done), "remounted_5s" (the same, and
  /// five seconds of neutral), "dark", "bright" (no other light, and three times as much), "recentred",
  /// "remounted_recentred" (as they were, and 2 mm off, but what has drifted is taken off every sensor).
  std::vector<SensorsMethod> conditions;

  [[nodiscard]] const SensorsMethod& learned() const { return methods[2]; }
};

/// Another face than people of the built-in family, and other tests.
struct MinuteScene {
  std::optional<face::Face> face;  ///< Who wears the glasses, each time with other skin, glasses and seat.
  std::vector<face::Motion>
      motions;  ///< Performed instead of the nineteen tests, whole; sets are empty then.
};

/// The network answers with displacements from the wearer's neutral markers, which are known. Uses the
/// request's wearers, test_s, seed and threads. The same arguments give the same numbers, whatever
/// the number of threads. Errors: those of rig, faults and model; bad_usage; cancelled. Cost: a minute and a
/// half of one core a wearer.
[[nodiscard]] Result<MinuteStudy> study_minute(const SensorsRequest& request, const sensor::Rig& rig,
                                               const builtin_face::MarkerSet& markers,
                                               const eyewear::MarkerNetworkFile& model,
                                               const MinuteScene& scene, const Progress& progress);

}  // namespace mien::lab
