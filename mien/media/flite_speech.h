#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/media/speech_synthesis.h"

namespace mien::media {

/// How voices of flite are told from espeak-ng's: "flite:slt".
inline constexpr std::string_view kFlitePrefix = "flite:";

/// speak() by a voice of flite, in US English: "slt", "rms" and "awb" were made of a person's recordings and
/// sound like one, "kal16" is joined of recorded pieces. 16 kHz; a rate of 175 is the voice's own pace; no
/// times of words. Errors: as speak(). Not thread-safe.
[[nodiscard]] Result<SpokenText> speak_by_flite(const std::string& voice, const std::string& text,
                                                int words_per_minute);

}  // namespace mien::media
