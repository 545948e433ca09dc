#include "mien/performer/speech.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mien/performer/tables.h"

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

const Language& find_language(std::string_view code) {
  // "en-gb" is spoken as "en".
  const std::string_view base = code.substr(0, code.find('-'));
  const auto found = std::ranges::find(tables().languages, base, &Language::code);
  return found != tables().languages.end() ? *found : tables().languages.front();
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
  static const std::vector<std::string_view> codes = [] {
    std::vector<std::string_view> all;
    for (const Language& language : tables().languages) all.emplace_back(language.code);
    return all;
  }();
  return codes;
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
  Utterance utterance{.language = language.code, .text = {}, .phonemes = {}, .duration_s = seconds};
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
