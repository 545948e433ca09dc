#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/eyewear/marker_network.h"
#include "mien/sensor/rig.h"

namespace mien::synthetic {

/// How much of what virtual wearers give to train on: the [data] table of a recipe for smart eyewear.
struct EyewearDataRecipe {
  std::uint64_t seed = 1;
  int wearers = 300;            ///< Each has an identity, skin, glasses and a seat of its own.
  int validation_wearers = 16;  ///< Held out: never trained on.
  /// What each performs after the first minute: seven tenths of poses that are held (components of marker
  /// motion as target poses have them, and random ones of a few shapes), the rest of reading, a range of
  /// motion and free motion. No emotion and no look of daily life is among them: studies test on those.
  double seconds = 120;
  bool operator==(const EyewearDataRecipe&) const = default;
};

/// Reads the table's text. Errors: malformed (no TOML); out_of_range (a value), bad_usage (a key), which they
/// name.
[[nodiscard]] Result<EyewearDataRecipe> parse_eyewear_data_recipe(std::string_view toml,
                                                                  const std::string& where);

/// What glasses see of one wearer, first minute and all, 60 frames a second. Arrays are frame-major.
struct LightSequence {
  std::uint32_t wearer = 0;
  std::size_t frames = 0;
  std::vector<float> values;          ///< frames x sensors: eyewear::LightFrame's.
  std::vector<std::uint8_t> present;  ///< The same.
  /// frames x 3 markers: displacement from neutral on the built-in face's default identity, metres, frame H.
  std::vector<float> displacement_m;
};

/// What a regressor of markers is trained on or measured on.
struct LightDataset {
  std::vector<std::string> sensors;
  std::vector<std::string> markers;
  std::vector<LightSequence> sequences;
  /// The markers on the face whose displacements the sequences hold; none where nobody needs weights.
  std::optional<eyewear::MarkedShapes> face;
};

struct EyewearData {
  LightDataset train;
  LightDataset validation;
};

/// Lets virtual wearers wear the rig's glasses. The same recipe, rig and markers give the same bits on any
/// number of threads; 0 threads: one a core. Errors: those of the rig's faults; cancelled. Cost: about two
/// minutes of one core an hour.
[[nodiscard]] Result<EyewearData> make_eyewear_dataset(const EyewearDataRecipe& recipe,
                                                       const sensor::Rig& rig,
                                                       const builtin_face::MarkerSet& markers,
                                                       const Progress& progress = no_progress,
                                                       unsigned threads = 0);

}  // namespace mien::synthetic
