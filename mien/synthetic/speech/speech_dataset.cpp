#include "mien/synthetic/speech/speech_dataset.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "mien/core/toml.h"
#include "mien/face/motion.h"
#include "mien/performer/lines.h"
#include "mien/speech/log_mel.h"
#include "mien/speech/speech_network.h"
#include "mien/synthetic/recipe_table.h"
#include "mien/synthetic/speech/other_sounds.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/virtual/performers.h"

namespace mien::synthetic {
namespace {

/// Variants of espeak-ng's voices: each speaks every language.
constexpr std::array<std::string_view, 12> kTrainingVariants = {
    "+m1", "+m2", "+m3", "+m4", "+m6", "+m8", "+f1", "+f2", "+f5", "+Annie", "+benjamin", "+steph"};
constexpr std::array<std::string_view, 3> kValidationVariants = {"+m7", "+f3", "+belinda"};
constexpr std::array<std::string_view, 6> kConfidenceVariants = {"+Denis", "+linda", "+Gene",
                                                                 "+Andy",  "+anika", "+paul"};
constexpr std::array<std::string_view, 3> kTestVariants = {"+m5", "+f4", "+michel"};
/// Made of people's recordings; each speaks one language. Those of flite are of whole sentences, or of pieces
/// of them; those of festival are joined of pieces.
struct Person {
  std::string_view voice;
  std::size_t language;
};
constexpr std::array kTrainingPeople = {Person{"flite:slt", 0}, Person{"flite:rms", 0},
                                        Person{"flite:kal16", 0}};
constexpr std::array kOtherPeople = {Person{"festival:lp_diphone", performer::kNoLanguage},
                                     Person{"festival:pc_diphone", performer::kNoLanguage},
                                     Person{"festival:czech_dita", performer::kNoLanguage},
                                     Person{"festival:czech_krb", performer::kNoLanguage},
                                     Person{"festival:czech_machac", performer::kNoLanguage},
                                     Person{"festival:czech_ph", performer::kNoLanguage},
                                     Person{"festival:hy_fi_mv_diphone", performer::kNoLanguage},
                                     Person{"festival:suo_fi_lj_diphone", performer::kNoLanguage},
                                     Person{"festival:msu_ru_nsh_clunits", performer::kNoLanguage}};
constexpr std::array kTestPeople = {Person{"flite:awb", 0}, Person{"festival:ked_diphone", 0}};
/// Lips need so long to meet and to part.
constexpr double kLipsMeet_s = 0.04;

constexpr std::array<std::string_view, 12> kShapes = {
    "jawOpen",        "mouthFunnel",  "mouthPucker", "mouthStretch",   "mouthSmile",     "mouthDimple",
    "mouthLowerDown", "mouthUpperUp", "mouthPress",  "mouthRollLower", "mouthRollUpper", "mouthShrugLower"};

/// What is heard, as a network is shown it.
void hear(std::span<const float> sound, SpeechSequence& out) {
  speech::LogMel mel;
  for (const speech::Block& block : blocks_of(sound)) {
    for (const speech::MelFrame& frame : mel.push(block))
      out.mel.insert(out.mel.end(), frame.begin(), frame.end());
    ++out.blocks;
  }
}

SpeechSequence sequence_of(const SpokenPassage& passage, const std::string& voice, std::size_t look_ahead) {
  SpeechSequence out;
  out.voice = voice;
  hear(passage.sound, out);
  const face::MotionCurve curve(passage.face);
  std::vector<std::size_t> places;
  for (const std::string& name : speech_shapes()) places.push_back(face::shape_index(name));
  const double block_s = to_seconds(speech::kBlockDuration);
  for (std::size_t b = 0; b < out.blocks; ++b) {
    const double at_s = block_s * (static_cast<double>(b) + 0.5 - static_cast<double>(look_ahead));
    const face::MotionFrame frame = curve.at(at_s);
    for (const std::size_t place : places) out.mouth.push_back(std::clamp(frame.weights[place], 0.0F, 1.0F));
    double closed = 0;
    for (const Closure& c : passage.closures)
      closed = std::max(closed, 1 - std::max({0.0, c.begin_s - at_s, at_s - c.end_s}) / kLipsMeet_s);
    out.closure.push_back(static_cast<float>(closed));
    out.voiced.push_back(passage.voiced_at(at_s) ? 1.0F : 0.0F);
  }
  return out;
}

SpeechSequence other_sequence(std::size_t kind, double seconds, const Random& random) {
  SpeechSequence out;
  out.voice = kOtherSoundNames[kind];
  out.speech = false;
  hear(make_other_sound(static_cast<OtherSound>(kind), static_cast<std::size_t>(seconds * speech::kRateHz),
                        random),
       out);
  out.mouth.resize(out.blocks * speech_shapes().size());
  out.closure.resize(out.blocks);
  out.voiced.resize(out.blocks);
  return out;
}

/// What becomes a sequence.
struct Piece {
  Voice voice;
  std::uint64_t number = 0;                     // Of the voice's passages.
  std::size_t other = kOtherSoundNames.size();  // Of kOtherSoundNames; else speech.
};

std::vector<Piece> pieces_for(const std::vector<Voice>& voices, int passages, int times_people = 1) {
  std::vector<Piece> pieces;
  for (const Voice& voice : voices) {
    const bool person = voice.name.contains(':');
    for (int p = 0; p < (person ? times_people * passages : passages); ++p)
      pieces.push_back({.voice = voice, .number = static_cast<std::uint64_t>(p)});
  }
  return pieces;
}

std::vector<Voice> as_voices(std::span<const Person> people) {
  std::vector<Voice> voices;
  for (const Person& person : people) voices.push_back({std::string(person.voice), person.language});
  return voices;
}

}  // namespace

std::vector<Voice> voices_for(VoiceUse use) {
  struct Speakers {
    std::span<const std::string_view> variants;
    std::span<const Person> people;
  };
  static const std::array<Speakers, 4> kSpeakers = {{{kTrainingVariants, kTrainingPeople},
                                                     {kValidationVariants, {}},
                                                     {kConfidenceVariants, {}},
                                                     {kTestVariants, kTestPeople}}};
  const auto& [variants, people] = kSpeakers[static_cast<std::size_t>(use)];
  std::vector<Voice> voices;
  const auto languages = performer::reading_languages();
  for (const std::string_view variant : variants)
    for (std::size_t l = 0; l < languages.size(); ++l)
      voices.push_back({std::string(languages[l].voice) + std::string(variant), l});
  std::ranges::move(as_voices(people), std::back_inserter(voices));
  return voices;
}

std::vector<std::string> speech_shapes() {
  std::vector<std::string> names;
  for (const std::string_view shape : kShapes) {
    if (face::shape_index(shape) < face::kShapeCount) {
      names.emplace_back(shape);
      continue;
    }
    for (const std::string_view side : {"_L", "_R"}) names.push_back(std::string(shape) + std::string(side));
  }
  return names;
}

Result<SpeechDataRecipe> parse_speech_data_recipe(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where + ", [data]"));
  constexpr std::int64_t kMostPassages = 1'000, kMostTimes = 100;
  SpeechDataRecipe recipe;
  RecipeTable data(table, "data.", where);
  data.number("seed", recipe.seed, 0, std::numeric_limits<std::int64_t>::max());
  data.number("passages", recipe.passages, 1, kMostPassages);
  data.number("validation_passages", recipe.validation_passages, 1, kMostPassages);
  data.number("people", recipe.people, 0, kMostTimes);
  data.number("other_people", recipe.other_people, 0, kMostTimes);
  data.number("other_seconds", recipe.other_seconds, 5, 3600);
  data.number("look_ahead", recipe.look_ahead, 0, 1);
  MIEN_TRY(data.finish());
  return recipe;
}

Result<SpeechData> make_speech_dataset(const SpeechDataRecipe& recipe, const performer::Speaker& speaker,
                                       const Progress& progress, unsigned threads) {
  std::vector<Piece> pieces = pieces_for(voices_for(VoiceUse::training), recipe.passages, recipe.people);
  std::ranges::move(pieces_for(as_voices(kOtherPeople), recipe.passages, recipe.other_people),
                    std::back_inserter(pieces));
  const auto add_others = [&](std::uint64_t number) {
    for (std::size_t kind = 0; kind < kOtherSoundNames.size(); ++kind)
      pieces.push_back({.voice = {}, .number = number, .other = kind});
  };
  add_others(0);
  const std::size_t trained = pieces.size();
  std::ranges::move(pieces_for(voices_for(VoiceUse::validation), recipe.validation_passages),
                    std::back_inserter(pieces));
  add_others(1);
  std::vector<SpeechSequence> sequences(pieces.size());
  const Random root(recipe.seed);
  MIEN_TRY(virt::for_each_performer(pieces.size(), threads, progress, [&](std::size_t i) -> Result<void> {
    const Piece& piece = pieces[i];
    if (piece.other < kOtherSoundNames.size()) {
      sequences[i] = other_sequence(piece.other, recipe.other_seconds,
                                    root.fork(kOtherSoundNames[piece.other], piece.number));
      return {};
    }
    MIEN_TRY_ASSIGN(const SpokenPassage passage,
                    speak_passage(speaker, piece.voice.name, piece.voice.language,
                                  root.fork(piece.voice.name, piece.number)));
    sequences[i] = sequence_of(passage, piece.voice.name, recipe.look_ahead);
    return {};
  }));
  SpeechData data;
  data.train.look_ahead = data.validation.look_ahead = recipe.look_ahead;
  const auto held_out = sequences.begin() + static_cast<std::ptrdiff_t>(trained);
  std::move(sequences.begin(), held_out, std::back_inserter(data.train.sequences));
  std::move(held_out, sequences.end(), std::back_inserter(data.validation.sequences));
  return data;
}

}  // namespace mien::synthetic
