#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/wav.h"

namespace mien::media {

/// A stretch of speech.
struct SpokenSpan {
  std::string text;  ///< The phoneme in IPA, or the word as written; UTF-8.
  double start_s = 0;
  double end_s = 0;  ///< > start_s, except for phonemes that the voice swallows.
};

/// Text read aloud by a machine, with the times of what it says.
struct SpokenText {
  Sound sound;                       ///< 22.05 kHz, of flite 16 kHz.
  std::vector<SpokenSpan> phonemes;  ///< In order; an empty text is a pause.
  std::vector<SpokenSpan> words;
};

/// Words a minute that voices speak.
inline constexpr int kSlowest = 80, kFastest = 450;
/// Errors: bad_usage (a rate beyond these), told of `where`.
[[nodiscard]] Result<void> check_rate(int words_per_minute, const std::string& where);

/// Reads `text` (UTF-8, at most 100,000 bytes) in a language of espeak-ng ("en-us", "de", "fr-fr", "es"),
/// with one of its voices' variants behind a "+" ("de+f3"), or by a voice of flite ("flite:slt"), at
/// `words_per_minute` (80 to 450; an ordinary reader 175). The same input gives the same bits with the same
/// espeak-ng and flite. Errors: bad_usage (an unknown language, a rate out of range, nothing to say), io (the
/// voices are not installed). Not thread-safe: espeak-ng has one voice at a time.
[[nodiscard]] Result<SpokenText> speak(const std::string& language, const std::string& text,
                                       int words_per_minute = 175);

/// The times as JSON: {language, text, words_per_minute, rate_hz, duration_s, phonemes: [{ipa, start_s,
/// end_s}], words: [{text, start_s, end_s}]}.
[[nodiscard]] std::string spoken_text_json(const std::string& language, const std::string& text,
                                           int words_per_minute, const SpokenText& spoken);

}  // namespace mien::media
