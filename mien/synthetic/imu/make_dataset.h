#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/dataset/dataset.h"
#include "mien/face/ict_import.h"
#include "mien/face/motion.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::synthetic {

/// How much of what virtual performers give to train on: the [data] table of a recipe.
struct DataRecipe {
  std::uint64_t seed = 1;
  int performers = 400;  ///< Drawn people; each has an identity, a style and a placement of its own.
  int validation_performers = 24;  ///< Held out: never trained on.
  double seconds = 120;            ///< What each performs in the lab profile.
  /// What each performs in the device profile, after a short prologue; 0: none. Simulated at 240 Hz and
  /// fused.
  double device_seconds = 30;
  double device_share = 1;  ///< Share of the performers that are simulated so.
  double device_long_share =
      0.2;  ///< Share of those whose session is 2.5 times as long, since headings drift.
  /// Share of those whose head moves as people wear such things, nodding, turning and walking whatever the
  /// face does; the others move it as suits what they perform.
  double device_moving_share = 0.5;
  /// Different people: the built-in family's identities, or ICT's.
  bool identities = true;
  /// How unlike the standard skin the least alike performers are; each one is by an even share of that, from
  /// none of it to all.
  double placement_mm = 3;            ///< Placement error along the skin, one sigma an axis.
  virt::KinematicsSpread kinematics;  ///< Drawn anew for each performer.
  /// Share of the training performers, 0 to 1, whose performances are made of recorded ones
  /// (performer::perform_recorded). Raising: closer to those people, less varied.
  double recorded_share = 0;
  std::vector<std::string> recorded;  ///< Names of the recordings in their folder, Live Link Face CSVs.
  bool operator==(const DataRecipe&) const = default;
};

/// Reads the table's text. Errors: malformed (no TOML); out_of_range (a value), bad_usage (a key), which they
/// name.
[[nodiscard]] Result<DataRecipe> parse_data_recipe(std::string_view toml, const std::string& where);

/// The recipe's recordings in `folder`, in its order. Errors: face::load_motion's; out_of_range (less than a
/// second with a face).
[[nodiscard]] Result<std::vector<face::Motion>> read_recorded(const DataRecipe& recipe,
                                                              const std::filesystem::path& folder);

/// Lets virtual performers perform; some by `recorded`, as the recipe says, where that is not empty. `face`
/// as face::load_face takes it; "builtin" draws identities of the built-in family, an ICT folder those of
/// ICT. The same recipe, face and rig give the same bits on any number of threads; 0 threads: one a core.
/// Errors: those of the face and the faults; cancelled. Cost: about a minute of one core an hour of lab
/// performance, three times that an hour of device performance.
[[nodiscard]] Result<dataset::TrainingData> make_dataset(const DataRecipe& recipe, const std::string& face,
                                                         const sensor::Rig& rig,
                                                         const Progress& progress = no_progress,
                                                         unsigned threads = 0,
                                                         std::span<const face::Motion> recorded = {});

}  // namespace mien::synthetic
