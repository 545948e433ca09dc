#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/gaze_targets.h"
#include "mien/face/profile.h"

namespace mien::session {

/// A pose that a person is asked for, by a face that makes it: for recordings that a model learns a wearer
/// from.
struct Prompt {
  std::string name;                ///< "brows up": 1 to 60 printable ASCII characters.
  std::string say;                 ///< What to do, in a sentence, 200 characters at most; may be empty.
  double seconds = 3;              ///< How long it is shown, 0.5 to 600.
  face::BlendshapeWeights target;  ///< 0 to 1 each.
  bool operator==(const Prompt&) const = default;
};

/// So many poses are asked for in one recording at most: over three hours of them.
inline constexpr std::size_t kMaxPrompts = 4096;

/// Whether every field is within what stands beside it. Errors: out_of_range.
[[nodiscard]] Result<void> check_prompt(const Prompt& prompt, const std::string& where);

/// The weights that are not 0 by their shapes' names, JSON: {"jawOpen": 0.5}. As few digits as bring the same
/// number back.
[[nodiscard]] std::string target_json(const face::BlendshapeWeights& target);
/// What a take's event of kind "prompt" says: {"name": ..., "target": {...}}.
[[nodiscard]] std::string prompt_event_json(const Prompt& prompt);
/// What one of kind "gaze" says, of a time in which the eyes rest on a target:
/// {"name": ..., "yaw_deg": ..., "pitch_deg": ...}.
[[nodiscard]] std::string gaze_event_json(const face::GazeTarget& target);
/// The target that such an event names; null where it names none.
[[nodiscard]] const face::GazeTarget* gaze_event_target(std::string_view json);

}  // namespace mien::session
