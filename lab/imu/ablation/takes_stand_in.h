#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/synthetic/imu/make_dataset.h"

namespace mien::lab {

/// Who stands in for people where no take of anybody is at hand.
struct StandInRequest {
  std::size_t people = 20;  ///< As CAPUS recorded.
  double seconds = 120;     ///< Of each.
  std::filesystem::path rig;
  std::uint64_t seed = 1;
};

/// What stands in for people's takes.
struct StandIn {
  /// Each person a performer, from takes, in *device*; every fifth validates. No slopes.
  dataset::TrainingData data;
  std::vector<std::string> left_out;  ///< Whose phone's time was not found, a sentence each.
};

/// Virtual people whom no training draws: faces of the built-in family, skin unlike the standard one's, every
/// other one performing what is shifted from training's distribution (draw_shifted_person), before a phone
/// with the faults of usual phones. They are labelled as people are: by what that phone told, at the time
/// that was found for it (phone_truth), never by the truth. Errors: film_wearer's; not_found (nobody is
/// left); cancelled. Cost: a core-second for 20 s of somebody.
[[nodiscard]] Result<StandIn> stand_in_takes(const StandInRequest& request, const Progress& progress);

}  // namespace mien::lab
