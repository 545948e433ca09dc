#pragma once

#include <string>
#include <vector>

#include "mien/performer/expression.h"
#include "mien/performer/expression_range.h"

namespace mien::performer {

/// A coupling of shapes by anatomy. Two of each: left and right.
struct Coupling {
  Pose from, to;
  float amount = 0;  ///< Mean over people.
};

/// A choice with its share; shares need not sum to anything.
struct Choice {
  std::string sounds;  ///< Separated by spaces.
  double share = 0;
};

/// What babble needs to know of a language.
struct Language {
  std::string code;
  double syllables_per_s = 0;
  double stress = 0;        ///< How much longer stressed syllables are than others, 0: all alike.
  double onset_chance = 0;  ///< That a syllable begins with a consonant.
  double coda_chance = 0;
  std::string weak_vowel;  ///< Of unstressed syllables; empty: none.
  std::vector<Choice> onsets, vowels, codas;
};

/// What tables.toml holds, in its order.
struct Tables {
  std::vector<Coupling> couplings;
  std::vector<Expression> emotions;  ///< By Emotion.
  std::vector<Expression> looks;
  std::vector<Exercise> exercises;
  std::vector<Language> languages;
};
/// Read at the first call.
[[nodiscard]] const Tables& tables();

}  // namespace mien::performer
