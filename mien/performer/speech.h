#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"

namespace mien::performer {

/// An utterance with the times of its phonemes.
struct Utterance {
  struct Phoneme {
    std::string ipa;  ///< As espeak-ng writes it, UTF-8: "tʃ", "aɪ", "ˈiː"; empty or "_" is silence.
    double start_s = 0;
    double end_s = 0;  ///< >= start_s.
    bool operator==(const Phoneme&) const = default;
  };
  std::string language;           ///< BCP 47: "en", "de", "cmn".
  std::string text;               ///< May be empty.
  std::vector<Phoneme> phonemes;  ///< In order of start_s; gaps are silence.
  double duration_s = 0;
  bool operator==(const Utterance&) const = default;
};

/// Reads {"language","text","rate_hz","phonemes":[{"ipa","start_s","end_s"}]}, as `mien-media speak` writes
/// it; an optional "duration_s" may be longer than the last phoneme. Errors: malformed, out_of_range (times
/// that are not finite, negative, out of order, beyond an hour), truncated.
[[nodiscard]] Result<Utterance> parse_utterance(std::string_view json);

/// Languages of random_utterance.
[[nodiscard]] std::span<const std::string_view> languages();

/// Random babble with the phonemes, syllables, rhythm and pauses of a language, `seconds` long. Unknown
/// languages become English. `rate`: speech rate, around 1.
[[nodiscard]] Utterance random_utterance(std::string_view language, double seconds, double rate,
                                         Random& random);

}  // namespace mien::performer
