#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/rig_constraints.h"
#include "mien/shaping/chain_step.h"
#include "mien/shaping/fallback.h"
#include "mien/shaping/limits.h"
#include "mien/shaping/merge_settings.h"

namespace mien::shaping {

/// User settings of shaping. Ranges and defaults: docs/reference/shaping_settings.md.
struct ShaperSettings {
  double smoothing = 0;      ///< 0 to 1. Raising: less jitter, more delay; 0: none (smoothing_for).
  bool smooth_head = false;  ///< True: the head is smoothed likewise.
  bool resting = false;      ///< True: the resting face is learnt from the last 30 s (Resting).
  /// Mean of spontaneous blinks of lids that no sensor observes, 0 to Blinks::kRateAtMost; 0: none (Blinks).
  double blinks_per_min = 12;
  bool lids_follow_eyes = true;  ///< False: the eyeLook shapes stay their tracker's (lids.h).
  Limits limits;                 ///< Gains and bounds of each shape (limits.h).
  bool constraints = false;      ///< True: all live `rules` are obeyed. False: those that always hold.
  face::RigConstraints rules = face::natural_constraints();  ///< Between shapes; RigConstraints(): none.
  FallbackSettings fallback;  ///< Times at the loss of sensors (fallback_settings.h).
  MergeSettings merge;        ///< Selection among several trackers.
  ChainSteps off;             ///< Steps that are left out, whatever else is set: to tell what each is worth.

  [[nodiscard]] bool runs(ChainStep step) const { return !off.test(static_cast<std::size_t>(step)); }
  bool operator==(const ShaperSettings&) const = default;
};

/// JSON, from which parse_settings restores equal settings: {"smoothing", "smooth_head", "resting",
/// "blinks_per_min", "lids_follow_eyes", "gains": {shape: gain}, "limits": {shape: [low, high]},
/// "constraints", "rules": a file's text, "fallback": {"hold_s", "neutral_s", "return_s"}, "merge": {"sure",
/// "unsure", "order": {place: [modality, ...]}}, "off": [step, ...]}; default gains, limits, "constraints",
/// "rules", "merge" and "off" are left out.
[[nodiscard]] std::string write_settings(const ShaperSettings& settings);
/// `base` with the fields of the JSON object; all are optional, and shapes that it does not name stay.
/// Errors: malformed (no JSON object, unknown key or shape, a value of another type), out_of_range (ranges:
/// limits.h, fallback_settings.h, merge_settings.h), face::RigConstraints::parse's. `where` names the source
/// in messages.
[[nodiscard]] Result<ShaperSettings> parse_settings(std::string_view json, const std::string& where,
                                                    const ShaperSettings& base = {});

}  // namespace mien::shaping
