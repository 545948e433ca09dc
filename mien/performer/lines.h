#pragma once

#include <span>
#include <string>
#include <string_view>

#include "mien/core/random.h"

namespace mien::performer {

/// A language in which lines are read.
struct ReadingLanguage {
  std::string_view voice;                   ///< As espeak-ng names it: "en-us".
  std::span<const std::string_view> lines;  ///< Every sound of the language comes up.
};

/// English, German, Spanish and French.
[[nodiscard]] std::span<const ReadingLanguage> reading_languages();

/// The language of nobody, after reading_languages(): letters that most languages of Europe speak alike, for
/// voices of languages without lines here.
inline constexpr std::size_t kNoLanguage = 4;

/// A line of words that do not exist, spelt after the rules of one of reading_languages() (its index) or of
/// kNoLanguage, so that any sequence of its sounds may come up: 4 to 9 words of 1 to 3 syllables.
[[nodiscard]] std::string invented_line(std::size_t language, Random& random);

}  // namespace mien::performer
