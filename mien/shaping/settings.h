#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/shaping/fallback.h"
#include "mien/shaping/limits.h"
#include "mien/shaping/merge_settings.h"

namespace mien::shaping {

/// What a person sets of the shaping.
struct ShaperSettings {
  double smoothing = 0;      ///< 0 to 1; 0 is none (smoothing_for says what it means and costs).
  bool smooth_head = false;  ///< Whether the head is smoothed likewise.
  Limits limits;
  FallbackSettings fallback;
  MergeSettings merge;  ///< Where several trackers watch one face (Merge); the Shaper has no use for it.
  bool operator==(const ShaperSettings&) const = default;
};

/// JSON text that parse_settings takes back to equal settings: {"smoothing", "smooth_head", "gains":
/// {shape: gain}, "limits": {shape: [low, high]}, "fallback": {"hold_s", "neutral_s", "return_s"}, "merge":
/// {"sure", "unsure", "order": {place: [modality, ...]}}}; gains, limits and "merge" that are the default are
/// left out.
[[nodiscard]] std::string write_settings(const ShaperSettings& settings);
/// `base` with what the JSON object names changed: every field is optional, and shapes that it does not name
/// keep what they have. Errors: malformed (no JSON object, unknown key or shape, a value of another type),
/// out_of_range (limits.h, fallback_settings.h and merge_settings.h say the ranges). `where` names the source
/// in messages.
[[nodiscard]] Result<ShaperSettings> parse_settings(std::string_view json, const std::string& where,
                                                    const ShaperSettings& base = {});

}  // namespace mien::shaping
