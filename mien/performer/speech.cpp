#include "mien/performer/speech.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace mien::performer {

namespace {

constexpr double kLongest_s = 3600;
constexpr std::size_t kMostPhonemes = 100'000;
constexpr std::size_t kLongestIpaBytes = 32;

using Json = nlohmann::json;

Result<double> read_time(const Json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number())
    return fail(ErrorCode::malformed, std::string("'") + key + "' is not a number", where);
  const double value = found->get<double>();
  if (!std::isfinite(value) || value < 0 || value > kLongest_s)
    return fail(ErrorCode::out_of_range, std::string("'") + key + "' is not between 0 and 3600 s", where);
  return value;
}

Result<std::string> read_string(const Json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string())
    return fail(ErrorCode::malformed, std::string("'") + key + "' is not a text", where);
  return found->get<std::string>();
}

/// A choice with its share; shares need not sum to anything.
struct Choice {
  std::string_view sounds;  ///< Separated by spaces.
  double share;
};

/// What babble needs to know of a language. Inventories after the handbook of the International Phonetic
/// Association (1999); shares are rough, most frequent sounds first; syllables a second after Pellegrino,
/// Coupé and Marsico 2011, doi:10.1353/lan.2011.0057.
struct Language {
  std::string_view code;
  double syllables_per_s;
  double stress;        ///< How much longer stressed syllables are than others, 0: all alike.
  double onset_chance;  ///< That a syllable begins with a consonant.
  double coda_chance;
  std::string_view weak_vowel;  ///< Of unstressed syllables; empty: none.
  std::span<const Choice> onsets;
  std::span<const Choice> vowels;
  std::span<const Choice> codas;
};

constexpr Choice kEnglishOnsets[] = {
    {"t", 7},     {"ð", 6},     {"s", 5},       {"d", 5},       {"w", 5},     {"m", 5},     {"b", 5},
    {"h", 4},     {"f", 4},     {"n", 4},       {"k", 4},       {"l", 4},     {"ɹ", 4},     {"p", 4},
    {"ɡ", 2},     {"v", 2},     {"j", 2},       {"ʃ", 2},       {"tʃ", 1},    {"dʒ", 1},    {"θ", 1},
    {"z", 1},     {"s t", 2},   {"t ɹ", 1},     {"p ɹ", 1.5},   {"p l", 1},   {"b ɹ", 0.7}, {"f ɹ", 0.8},
    {"k l", 0.6}, {"s p", 0.8}, {"s t ɹ", 0.5}, {"s k w", 0.2}, {"k w", 0.4}, {"f l", 0.5}};
constexpr Choice kEnglishVowels[] = {{"ɪ", 9},  {"ɛ", 6},  {"æ", 6},  {"iː", 6}, {"ʌ", 4},
                                     {"aɪ", 5}, {"eɪ", 5}, {"oʊ", 4}, {"uː", 4}, {"ɔː", 4},
                                     {"ɑː", 4}, {"ɜː", 2}, {"ʊ", 2},  {"aʊ", 2}, {"ɔɪ", 0.5}};
constexpr Choice kEnglishCodas[] = {{"n", 9},   {"t", 7},   {"d", 6},     {"z", 5},    {"l", 5},   {"s", 4},
                                    {"ɹ", 4},   {"m", 4},   {"k", 3},     {"v", 3},    {"ŋ", 3},   {"p", 2},
                                    {"f", 1.5}, {"b", 0.5}, {"ʃ", 0.5},   {"tʃ", 1},   {"n d", 2}, {"s t", 2},
                                    {"n t", 2}, {"k s", 1}, {"l d", 0.7}, {"m p", 0.5}};

constexpr Choice kGermanOnsets[] = {{"d", 8},     {"z", 5},     {"v", 5},     {"ʁ", 4},     {"ɡ", 5},
                                    {"f", 5},     {"b", 6},     {"m", 5},     {"n", 4},     {"t", 4},
                                    {"h", 4},     {"l", 3},     {"k", 3},     {"j", 2},     {"ʃ", 2},
                                    {"p", 2},     {"ts", 2},    {"pf", 0.5},  {"ʃ t", 2},   {"ʃ p", 1},
                                    {"k l", 0.5}, {"f ʁ", 0.5}, {"t ʁ", 0.5}, {"ʃ v", 0.4}, {"ʔ", 5}};
constexpr Choice kGermanVowels[] = {{"a", 7},  {"ɪ", 7},   {"aɪ", 5}, {"ɛ", 6},   {"iː", 5}, {"ʊ", 4},
                                    {"aː", 5}, {"eː", 5},  {"ɔ", 3},  {"uː", 3},  {"oː", 3}, {"aʊ", 3},
                                    {"yː", 2}, {"ʏ", 1.5}, {"øː", 1}, {"œ", 0.7}, {"ɔʏ", 1}};
constexpr Choice kGermanCodas[] = {{"n", 12}, {"ɐ", 4},   {"t", 6},   {"s", 5},   {"l", 3},  {"m", 3},
                                   {"ç", 4},  {"x", 3},   {"k", 2},   {"f", 1.5}, {"ŋ", 2},  {"p", 1},
                                   {"ʃ", 1},  {"s t", 2}, {"n t", 3}, {"ts", 1},  {"ç t", 1}};

constexpr Choice kSpanishOnsets[] = {
    {"s", 7},   {"d", 6},   {"k", 6},     {"t", 6},     {"m", 5},   {"l", 6},   {"p", 5},
    {"n", 4},   {"ɾ", 5},   {"b", 4},     {"β", 2},     {"ð", 3},   {"ɡ", 1},   {"ɣ", 1},
    {"f", 1},   {"x", 1},   {"tʃ", 0.5},  {"r", 1},     {"θ", 2},   {"ʝ", 0.5}, {"ɲ", 0.4},
    {"p ɾ", 1}, {"t ɾ", 1}, {"k l", 0.3}, {"b l", 0.3}, {"w", 0.7}, {"j", 0.7}};
constexpr Choice kSpanishVowels[] = {{"e", 13},   {"a", 12}, {"o", 10},   {"i", 6},    {"u", 3},
                                     {"je", 1.5}, {"we", 1}, {"ei", 0.6}, {"ai", 0.4}, {"au", 0.3}};
constexpr Choice kSpanishCodas[] = {{"s", 8}, {"n", 7}, {"ɾ", 4}, {"l", 3}, {"m", 1}, {"ð", 0.5}};

constexpr Choice kJapaneseOnsets[] = {{"k", 9},   {"t", 7},     {"n", 7},    {"s", 5},  {"ɾ", 5}, {"m", 5},
                                      {"d", 3},   {"ɡ", 3},     {"ɕ", 5},    {"h", 3},  {"w", 2}, {"j", 2},
                                      {"dʑ", 2},  {"tɕ", 2},    {"b", 1.5},  {"ts", 2}, {"z", 1}, {"ɸ", 1},
                                      {"p", 0.4}, {"k j", 0.5}, {"ɾ j", 0.3}};
constexpr Choice kJapaneseVowels[] = {{"a", 10}, {"i", 8},  {"ɯ", 7},    {"e", 6}, {"o", 9},
                                      {"oː", 3}, {"eː", 2}, {"aː", 0.6}, {"ɯː", 1}};
constexpr Choice kJapaneseCodas[] = {{"ɴ", 6}, {"m", 1}, {"ʔ", 2}};

constexpr Choice kFrenchOnsets[] = {{"l", 7},   {"s", 6},   {"d", 6},   {"ʁ", 6},     {"t", 5},    {"p", 5},
                                    {"k", 5},   {"m", 5},   {"n", 4},   {"v", 4},     {"f", 2},    {"b", 2},
                                    {"ʒ", 3},   {"z", 2},   {"ʃ", 1},   {"ɡ", 1},     {"j", 2},    {"w", 2},
                                    {"ɥ", 0.7}, {"p ʁ", 1}, {"t ʁ", 1}, {"p l", 0.5}, {"b l", 0.4}};
constexpr Choice kFrenchVowels[] = {{"a", 8}, {"e", 7}, {"i", 6}, {"ɛ", 5}, {"ə", 5},
                                    {"ɑ̃", 4}, {"y", 3}, {"u", 3}, {"ɔ̃", 3}, {"o", 3},
                                    {"ɔ", 2}, {"ɛ̃", 2}, {"ø", 1}, {"œ", 1}, {"œ̃", 0.5}};
constexpr Choice kFrenchCodas[] = {{"ʁ", 6},   {"l", 3},   {"t", 2},   {"s", 2},   {"z", 1.5}, {"k", 1.5},
                                   {"m", 1.5}, {"n", 1.5}, {"p", 0.7}, {"b", 0.3}, {"ʒ", 1},   {"j", 1}};

constexpr Choice kMandarinOnsets[] = {{"t", 8},    {"ʂ", 5},   {"l", 4},   {"tɕ", 5},  {"ɕ", 4},    {"j", 6},
                                      {"w", 4},    {"k", 4},   {"p", 4},   {"m", 3},   {"ʈʂ", 4},   {"tʰ", 3},
                                      {"x", 4},    {"n", 3},   {"tɕʰ", 3}, {"ɻ", 2},   {"f", 2},    {"kʰ", 2},
                                      {"pʰ", 1.5}, {"ʈʂʰ", 2}, {"ts", 2},  {"s", 1.5}, {"tsʰ", 1.5}};
constexpr Choice kMandarinVowels[] = {{"a", 8},   {"i", 8},   {"ɤ", 7},   {"ə", 6},  {"u", 6}, {"ai", 4},
                                      {"au", 4},  {"ou", 4},  {"ei", 3},  {"wo", 4}, {"y", 2}, {"jɛ", 2},
                                      {"wei", 2}, {"jou", 2}, {"ɚ", 0.5}, {"ɻ̩", 3}};
constexpr Choice kMandarinCodas[] = {{"n", 6}, {"ŋ", 5}};

constexpr Language kLanguages[] = {
    {"en", 6.2, 0.55, 0.85, 0.55, "ə", kEnglishOnsets, kEnglishVowels, kEnglishCodas},
    {"de", 6.0, 0.50, 0.92, 0.60, "ə", kGermanOnsets, kGermanVowels, kGermanCodas},
    {"es", 7.8, 0.25, 0.85, 0.25, "", kSpanishOnsets, kSpanishVowels, kSpanishCodas},
    {"fr", 7.2, 0.10, 0.88, 0.22, "", kFrenchOnsets, kFrenchVowels, kFrenchCodas},
    {"ja", 7.8, 0.05, 0.88, 0.12, "", kJapaneseOnsets, kJapaneseVowels, kJapaneseCodas},
    {"cmn", 5.2, 0.15, 0.92, 0.28, "", kMandarinOnsets, kMandarinVowels, kMandarinCodas}};

constexpr auto kCodes = [] {
  std::array<std::string_view, std::size(kLanguages)> codes;
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = kLanguages[i].code;
  return codes;
}();

const Language& find_language(std::string_view code) {
  // "en-gb" is spoken as "en".
  const std::string_view base = code.substr(0, code.find('-'));
  for (const Language& language : kLanguages)
    if (language.code == base) return language;
  return kLanguages[0];
}

std::string_view pick(std::span<const Choice> choices, Random& random) {
  double sum = 0;
  for (const Choice& choice : choices) sum += choice.share;
  double u = random.uniform(0, sum);
  for (const Choice& choice : choices) {
    u -= choice.share;
    if (u < 0) return choice.sounds;
  }
  return choices.back().sounds;
}

/// Usual lengths in careful speech, s, before a phrase is brought to its rate (Crystal and House 1988,
/// doi:10.1121/1.396251, rounded).
double consonant_s(std::string_view ipa) {
  for (const std::string_view c : {"tʃ", "dʒ", "ts", "pf", "tɕ", "dʑ", "ʈʂ"})
    if (ipa.starts_with(c)) return 0.11;
  for (const std::string_view c : {"s", "z", "ʃ", "ʒ", "f", "θ", "ç", "x", "ɕ", "ʂ"})
    if (ipa.starts_with(c)) return 0.095;
  for (const std::string_view c : {"ɾ", "ð", "ʔ", "ɣ", "β"})
    if (ipa.starts_with(c)) return 0.04;
  for (const std::string_view c : {"w", "j", "ɥ", "l", "ɹ", "h", "ɻ"})
    if (ipa.starts_with(c)) return 0.06;
  return 0.075;
}

double vowel_s(std::string_view ipa) {
  const bool is_long = ipa.ends_with("ː") || ipa.ends_with("\u0303");
  // Two vowel letters: every IPA vowel but a, e, i, o, u, y takes two bytes, so three bytes are two letters
  // or a mark.
  const bool glides = !is_long && ipa.size() >= (static_cast<unsigned char>(ipa.front()) < 0x80 ? 2U : 3U);
  return is_long || glides ? 0.125 : 0.085;
}

/// Puts the sounds of one syllable behind `phonemes`; start_s holds lengths for now.
void add_syllable(const Language& language, bool stressed, double lengthening, Utterance& utterance,
                  Random& random) {
  const auto add = [&](std::string_view ipa, double seconds) {
    utterance.phonemes.push_back(
        {std::string(ipa), seconds * std::clamp(random.log_normal(0.2), 0.6, 1.6), 0});
  };
  const auto add_consonants = [&](std::string_view sounds, double factor) {
    while (!sounds.empty()) {
      const std::size_t space = std::min(sounds.find(' '), sounds.size());
      add(sounds.substr(0, space), factor * consonant_s(sounds.substr(0, space)));
      sounds.remove_prefix(std::min(space + 1, sounds.size()));
    }
  };
  if (random.chance(language.onset_chance)) add_consonants(pick(language.onsets, random), 1);
  const bool weak = !stressed && !language.weak_vowel.empty() && random.chance(0.55);
  const std::string_view vowel = weak ? language.weak_vowel : pick(language.vowels, random);
  const double stretch = (stressed ? 1 + language.stress : 1) * (weak ? 0.65 : 1.0) * lengthening;
  add((stressed ? "ˈ" : "") + std::string(vowel), stretch * vowel_s(vowel));
  if (random.chance(language.coda_chance))
    add_consonants(pick(language.codas, random), 0.5 + 0.5 * lengthening);
}

}  // namespace

std::span<const std::string_view> languages() {
  return kCodes;
}

Result<Utterance> parse_utterance(std::string_view json) {
  const std::string where = "utterance";
  const Json document = Json::parse(json, nullptr, false);
  if (document.is_discarded() || !document.is_object())
    return fail(ErrorCode::malformed, "it is not a JSON object", where, "make it with 'mien-media speak'");
  Utterance utterance;
  MIEN_TRY_ASSIGN(utterance.language, read_string(document, "language", where));
  if (document.contains("text")) {
    MIEN_TRY_ASSIGN(utterance.text, read_string(document, "text", where));
  }
  const auto phonemes = document.find("phonemes");
  if (phonemes == document.end() || !phonemes->is_array())
    return fail(ErrorCode::malformed, "'phonemes' is not a list", where);
  if (phonemes->size() > kMostPhonemes)
    return fail(ErrorCode::out_of_range, "there are more than 100000 phonemes", where);
  for (std::size_t i = 0; i < phonemes->size(); ++i) {
    const Json& entry = (*phonemes)[i];
    const std::string here = where + ", phoneme " + std::to_string(i + 1);
    if (!entry.is_object()) return fail(ErrorCode::malformed, "it is not an object", here);
    Utterance::Phoneme phoneme;
    MIEN_TRY_ASSIGN(phoneme.ipa, read_string(entry, "ipa", here));
    MIEN_TRY_ASSIGN(phoneme.start_s, read_time(entry, "start_s", here));
    MIEN_TRY_ASSIGN(phoneme.end_s, read_time(entry, "end_s", here));
    if (phoneme.ipa.size() > kLongestIpaBytes)
      return fail(ErrorCode::out_of_range, "'ipa' is longer than 32 bytes", here);
    if (phoneme.end_s < phoneme.start_s)
      return fail(ErrorCode::out_of_range, "it ends before it starts", here);
    if (!utterance.phonemes.empty() && phoneme.start_s < utterance.phonemes.back().start_s)
      return fail(ErrorCode::out_of_range, "it starts before the one before it", here,
                  "sort the phonemes by start_s");
    utterance.duration_s = std::max(utterance.duration_s, phoneme.end_s);
    utterance.phonemes.push_back(std::move(phoneme));
  }
  if (document.contains("duration_s")) {
    MIEN_TRY_ASSIGN(const double declared, read_time(document, "duration_s", where));
    utterance.duration_s = std::max(utterance.duration_s, declared);
  }
  return utterance;
}

Utterance random_utterance(std::string_view language_code, double seconds, double rate, Random& random) {
  const Language& language = find_language(language_code);
  Utterance utterance{
      .language = std::string(language.code), .text = {}, .phonemes = {}, .duration_s = seconds};
  double now_s = random.uniform(0.05, 0.3);
  bool sentence_ends = false;
  while (now_s < seconds) {
    const std::size_t first = utterance.phonemes.size();
    const std::size_t syllables = 3 + random.below(11);
    for (std::size_t s = 0; s < syllables; ++s) {
      const bool stressed = language.stress > 0.3 ? (s % 2 == 0 && random.chance(0.75)) || random.chance(0.15)
                                                  : random.chance(0.3);
      // Before a pause everything slows down.
      const double lengthening = s + 1 == syllables ? 1.6 : s + 2 == syllables ? 1.15 : 1.0;
      add_syllable(language, stressed, lengthening, utterance, random);
    }
    double length_s = 0;
    for (std::size_t i = first; i < utterance.phonemes.size(); ++i) length_s += utterance.phonemes[i].start_s;
    const double wanted_s = static_cast<double>(syllables) / (language.syllables_per_s * rate) *
                            std::clamp(random.log_normal(0.1), 0.8, 1.3);
    for (std::size_t i = first; i < utterance.phonemes.size(); ++i) {
      auto& phoneme = utterance.phonemes[i];
      const double own_s = std::max(0.025, phoneme.start_s * wanted_s / length_s);
      phoneme.start_s = now_s;
      now_s += own_s;
      phoneme.end_s = now_s;
    }
    sentence_ends = !sentence_ends && random.chance(0.5);
    now_s += (sentence_ends ? random.uniform(0.4, 1.1) : random.uniform(0.12, 0.45)) / std::sqrt(rate);
  }
  std::erase_if(utterance.phonemes, [&](const auto& phoneme) { return phoneme.end_s > seconds; });
  return utterance;
}

}  // namespace mien::performer
