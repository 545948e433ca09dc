#include "mien/media/speech_synthesis.h"

#include <espeak-ng/espeak_ng.h>
#include <espeak-ng/speak_lib.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "mien/media/flite_speech.h"

namespace mien::media {
namespace {

/// What espeak-ng says while it speaks; it hands it to a plain function.
struct Synthesised {
  struct Mark {
    int kind;
    double time_s;
    std::string phoneme;
    std::size_t position, length;  // Of a word: characters, from 0.
  };
  std::vector<std::int16_t> samples;
  std::vector<Mark> marks;
};

int listen(short* samples, int count, espeak_EVENT* events) {
  if (events == nullptr || events->user_data == nullptr) return 0;
  Synthesised& synthesised = *static_cast<Synthesised*>(events->user_data);
  if (samples != nullptr && count > 0)
    synthesised.samples.insert(synthesised.samples.end(), samples, samples + count);
  for (const espeak_EVENT* e = events; e->type != espeakEVENT_LIST_TERMINATED; ++e) {
    Synthesised::Mark mark{
        .kind = e->type, .time_s = e->audio_position * 1e-3, .phoneme = {}, .position = 0, .length = 0};
    if (e->type == espeakEVENT_PHONEME)
      mark.phoneme.assign(e->id.string, strnlen(e->id.string, sizeof e->id.string));
    else if (e->type == espeakEVENT_WORD && e->text_position > 0) {
      mark.position = static_cast<std::size_t>(e->text_position - 1);
      mark.length = static_cast<std::size_t>(std::max(0, e->length));
    } else if (e->type != espeakEVENT_END) {
      continue;
    }
    synthesised.marks.push_back(std::move(mark));
  }
  return 0;
}

/// Characters [first, first + count) of UTF-8 text.
std::string characters(const std::string& text, std::size_t first, std::size_t count) {
  std::string part;
  std::size_t index = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U;
    if (begins && i > 0) ++index;
    if (index >= first && index < first + count) part += text[i];
  }
  return part;
}

/// Whether some voice lists this language. Its list is runs of a priority byte and a name, ended by a zero.
bool speaks(const std::string& language) {
  for (const espeak_VOICE** voice = espeak_ListVoices(nullptr); voice != nullptr && *voice != nullptr;
       ++voice)
    for (const char* entry = (*voice)->languages; *entry != 0; entry += std::strlen(entry + 1) + 2)
      if (language == entry + 1) return true;
  return false;
}

/// espeak-ng takes a variant that it does not know for none.
bool has_variant(const std::string& variant) {
  espeak_VOICE wanted{};
  wanted.languages = "variant";
  for (const espeak_VOICE** voice = espeak_ListVoices(&wanted); voice != nullptr && *voice != nullptr;
       ++voice)
    if (std::string_view((*voice)->identifier).ends_with("/" + variant)) return true;
  return false;
}

/// A voice is found by its own name ("de") or by a language that it also speaks ("fr-fr" is French's); what
/// stands behind a "+" is a variant of it.
bool choose_voice(const std::string& name) {
  const std::size_t plus = std::min(name.find('+'), name.size());
  if (plus < name.size() && !has_variant(name.substr(plus + 1))) return false;
  if (espeak_SetVoiceByName(name.c_str()) == EE_OK) return true;
  const std::string language = name.substr(0, plus);
  espeak_VOICE wanted{};
  wanted.languages = language.c_str();
  if (!speaks(language) || espeak_SetVoiceByProperties(&wanted) != EE_OK) return false;
  if (plus == name.size()) return true;
  const espeak_VOICE* const found = espeak_GetCurrentVoice();
  return found != nullptr && espeak_SetVoiceByName((found->identifier + name.substr(plus)).c_str()) == EE_OK;
}

}  // namespace

Result<void> check_rate(int words_per_minute, const std::string& where) {
  if (words_per_minute >= kSlowest && words_per_minute <= kFastest) return {};
  return fail(ErrorCode::bad_usage, fmt::format("a rate of {} words a minute", words_per_minute), where,
              fmt::format("choose {} to {}", kSlowest, kFastest));
}

Result<SpokenText> speak(const std::string& language, const std::string& text, int words_per_minute) {
  constexpr std::size_t kMaxText = 100'000;
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    return fail(ErrorCode::bad_usage, "there is nothing to say", language, "give a text");
  if (text.size() > kMaxText)
    return fail(ErrorCode::bad_usage, fmt::format("a text of {} bytes is too long", text.size()), language,
                "cut it into pieces of at most 100000");
  MIEN_TRY(check_rate(words_per_minute, language));
  if (language.starts_with(kFlitePrefix))
    return speak_by_flite(language.substr(kFlitePrefix.size()), text, words_per_minute);
  const int rate_hz = espeak_Initialize(
      AUDIO_OUTPUT_RETRIEVAL, 0, nullptr,
      espeakINITIALIZE_PHONEME_EVENTS | espeakINITIALIZE_PHONEME_IPA | espeakINITIALIZE_DONT_EXIT);
  if (rate_hz <= 0)
    return fail(ErrorCode::io, "espeak-ng finds no voices", language, "install Debian's espeak-ng-data");
  if (!choose_voice(language))
    return fail(ErrorCode::bad_usage, "espeak-ng has no such voice", language, "see espeak-ng --voices");
  espeak_SetParameter(espeakRATE, words_per_minute, 0);
  espeak_SetSynthCallback(&listen);

  Synthesised synthesised;
  if (espeak_Synth(text.c_str(), text.size() + 1, 0, POS_CHARACTER, 0, espeakCHARS_UTF8, nullptr,
                   &synthesised) != EE_OK ||
      espeak_Synchronize() != EE_OK)
    return fail(ErrorCode::io, "espeak-ng gave up on this text", language);
  if (synthesised.samples.empty())
    return fail(ErrorCode::bad_usage, "espeak-ng finds nothing to say", language, "give a text");

  SpokenText spoken;
  spoken.sound.rate_hz = static_cast<std::uint32_t>(rate_hz);
  spoken.sound.samples.reserve(synthesised.samples.size());
  for (const std::int16_t s : synthesised.samples)
    spoken.sound.samples.push_back(static_cast<float>(s) / 32768.0F);
  const double duration_s = spoken.sound.duration_s();

  // A phoneme lasts until the next one, a word until the next one or the end of its clause.
  bool in_phoneme = false, in_word = false;
  const auto end_both = [&](double time_s, bool phoneme, bool word) {
    if (phoneme && in_phoneme)
      spoken.phonemes.back().end_s = std::max(spoken.phonemes.back().start_s, time_s);
    if (word && in_word) spoken.words.back().end_s = std::max(spoken.words.back().start_s, time_s);
    if (phoneme) in_phoneme = false;
    if (word) in_word = false;
  };
  for (const Synthesised::Mark& mark : synthesised.marks) {
    const double time_s = std::min(mark.time_s, duration_s);
    if (mark.kind == espeakEVENT_PHONEME) {
      end_both(time_s, true, false);
      // A mark without a sound ends a clause: what follows is a pause.
      std::string ipa = mark.phoneme == "_:" || mark.phoneme == "_" ? "" : mark.phoneme;
      spoken.phonemes.push_back({std::move(ipa), time_s, time_s});
      in_phoneme = true;
    } else if (mark.kind == espeakEVENT_WORD) {
      end_both(time_s, false, true);
      spoken.words.push_back({characters(text, mark.position, mark.length), time_s, time_s});
      in_word = true;
    } else {
      end_both(time_s, true, true);
    }
  }
  end_both(duration_s, true, true);

  // One pause is one span, and a pause that takes no time is none.
  std::vector<SpokenSpan> phonemes;
  for (SpokenSpan& p : spoken.phonemes) {
    const bool pause = p.text.empty();
    if (pause && !phonemes.empty() && phonemes.back().text.empty())
      phonemes.back().end_s = p.end_s;
    else if (!pause || p.end_s > p.start_s)
      phonemes.push_back(std::move(p));
  }
  spoken.phonemes = std::move(phonemes);
  return spoken;
}

std::string spoken_text_json(const std::string& language, const std::string& text, int words_per_minute,
                             const SpokenText& spoken) {
  using nlohmann::ordered_json;
  const auto list = [](const std::vector<SpokenSpan>& spans, const char* name) {
    ordered_json all = ordered_json::array();
    for (const SpokenSpan& s : spans)
      all.push_back({{name, s.text}, {"start_s", s.start_s}, {"end_s", s.end_s}});
    return all;
  };
  const ordered_json tree = {{"language", language},
                             {"text", text},
                             {"words_per_minute", words_per_minute},
                             {"rate_hz", spoken.sound.rate_hz},
                             {"duration_s", spoken.sound.duration_s()},
                             {"phonemes", list(spoken.phonemes, "ipa")},
                             {"words", list(spoken.words, "text")}};
  return tree.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace mien::media
