#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::session {

/// What a performer agreed to before they were recorded for a dataset. It stands in the take, as an event of
/// the kind "consent": what the take holds from then on is the dataset's, and nothing before.
struct Consent {
  std::string performer;    ///< Name or code of who is recorded: 1 to 60 bytes of UTF-8, one line, as all.
  std::string recorded_by;  ///< Who records it and keeps it: 1 to 200.
  std::string purpose;      ///< What for: 1 to 1000.
  bool sound = false;       ///< Whether the voice is recorded too, ...
  bool video = false;       ///< ... and the face on video, in a file beside the take.
  bool operator==(const Consent&) const = default;
};

/// Whether every field is within what stands beside it. Errors: out_of_range.
[[nodiscard]] Result<void> check_consent(const Consent& consent, const std::string& where);

/// What such an event says, JSON: {"performer", "recorded_by", "purpose", "sound", "video"}.
[[nodiscard]] std::string consent_event_json(const Consent& consent);
/// The consent that such an event tells of; none where it tells of none. What it does not say of sound and
/// video was not agreed to.
[[nodiscard]] std::optional<Consent> consent_of(std::string_view json);

}  // namespace mien::session
