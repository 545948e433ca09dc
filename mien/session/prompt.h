#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/gaze_targets.h"
#include "mien/face/profile.h"

namespace mien::session {

/// What a person is asked for while they are recorded: a pose, by a face that makes it, or a line to read.
struct Prompt {
  std::string name;                ///< "brows up": 1 to 60 printable ASCII characters.
  std::string say;                 ///< What to do, in a sentence: UTF-8, 200 bytes at most; may be empty.
  double seconds = 3;              ///< How long it is shown, 0.5 to 600.
  face::BlendshapeWeights target;  ///< 0 to 1 each.
  std::string text;                ///< To be read aloud: UTF-8, 2000 bytes at most; empty: nothing is.
  /// Part of a recording script ("calm"): printable ASCII, 40 characters at most, as `emotion`. Empty: it
  /// belongs to none, and is no line of a dataset.
  std::string block;
  std::string emotion;   ///< Label: "neutral", "joy", ...; empty: none.
  std::string language;  ///< Of the text, as BCP 47 has it ("en"), 35 characters at most; empty: none.
  /// Shown until the performer goes on, 600 s at most; `seconds` is what it usually takes.
  bool own_pace = false;
  int attempt = 1;  ///< 2 to kMaxAttempts: it is asked for again.
  bool operator==(const Prompt&) const = default;
};

/// A line that was poor is asked for this often at most.
inline constexpr int kMaxAttempts = 3;

/// So many poses are asked for in one recording at most: over three hours of them.
inline constexpr std::size_t kMaxPrompts = 4096;

/// Whether every field is within what stands beside it. Errors: out_of_range.
[[nodiscard]] Result<void> check_prompt(const Prompt& prompt, const std::string& where);

/// The weights that are not 0 by their shapes' names, JSON: {"jawOpen": 0.5}. As few digits as bring the same
/// number back.
[[nodiscard]] std::string target_json(const face::BlendshapeWeights& target);
/// What a take's event of kind "prompt" says: {"name": ..., "target": {...}}, without a target where a text
/// was read and no pose asked for; labels where it has some; `poor`: what was poor, a sentence each.
[[nodiscard]] std::string prompt_event_json(const Prompt& prompt, std::span<const std::string> poor = {});
/// What one of kind "gaze" says, of a time in which the eyes rest on a target:
/// {"name": ..., "yaw_deg": ..., "pitch_deg": ...}.
[[nodiscard]] std::string gaze_event_json(const face::GazeTarget& target);
/// The target that such an event names; null where it names none.
[[nodiscard]] const face::GazeTarget* gaze_event_target(std::string_view json);

}  // namespace mien::session
