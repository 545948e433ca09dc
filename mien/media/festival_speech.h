#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/media/speech_synthesis.h"

namespace mien::media {

/// How voices of festival are told from espeak-ng's: "festival:czech_dita".
inline constexpr std::string_view kFestivalPrefix = "festival:";

/// What has festival (its program, `festival -b FILE`) read `text` into a WAV, and print when each phone
/// ends. Of its voices those in whose language letters are spoken as they stand: lp_diphone, pc_diphone
/// (Italian), czech_dita, czech_krb, czech_machac, czech_ph, hy_fi_mv_diphone, suo_fi_lj_diphone (Finnish),
/// msu_ru_nsh_clunits (Russian), and English ked_diphone. All are joined of a person's recordings; a rate of
/// 175 is the voice's own pace. Errors: bad_usage (another voice; a text that is empty or not ASCII, which is
/// all that they read alike).
[[nodiscard]] Result<std::string> festival_script(const std::string& voice, const std::string& text,
                                                  int words_per_minute, const std::filesystem::path& wav);

/// What that printed, as phonemes. Lines of a voice's own are passed over. Errors: malformed (a phone without
/// its end, ends that run back or are not finite).
[[nodiscard]] Result<std::vector<SpokenSpan>> parse_festival_phones(std::string_view printed,
                                                                    const std::string& voice);

}  // namespace mien::media
