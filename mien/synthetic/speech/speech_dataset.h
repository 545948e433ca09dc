#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/performer/speaker.h"

namespace mien::synthetic {

/// How much of what virtual speakers say to train on: the [data] table of a recipe for speech.
struct SpeechDataRecipe {
  std::uint64_t seed = 1;
  int passages = 8;  ///< Of three lines each, by every variant of espeak-ng's voices.
  /// How many times as many are said by each English voice that was made of a person's recordings (flite):
  /// they are few. Raising: more like people, less like each language's synthetic voices.
  int people = 12;
  /// The same of nine such voices of other languages (festival, script/packages/voices.txt). They helped
  /// nobody who was listened to (docs/experiments/speech.md), so by default there are none.
  int other_people = 0;
  int validation_passages = 2;  ///< By each variant that is held out.
  double other_seconds = 120;   ///< Of each kind of sound that is no speech.
  std::size_t look_ahead = 1;   ///< What a network's answer is delayed by, blocks: 0 or 1.
  bool operator==(const SpeechDataRecipe&) const = default;
};

/// Reads the table's text. Errors: malformed (no TOML); out_of_range (a value), bad_usage (a key), which they
/// name.
[[nodiscard]] Result<SpeechDataRecipe> parse_speech_data_recipe(std::string_view toml,
                                                                const std::string& where);

/// Who speaks, and in which of reading_languages(), or kNoLanguage.
struct Voice {
  std::string name;  ///< As Speaker takes it.
  std::size_t language = 0;
};
/// None is in two of the four. On those for confidence a network's table of confidence is measured; those for
/// tests are heard by `mien study speech`, and by nothing that learns or chooses.
enum class VoiceUse : std::uint8_t { training, validation, confidence, test };
[[nodiscard]] std::vector<Voice> voices_for(VoiceUse use);

/// The shapes that a network of speech answers for, by name: what performer::perform_speech moves.
[[nodiscard]] std::vector<std::string> speech_shapes();

/// One passage, block by block. Arrays are block-major; truth is that of the mouth `look_ahead` blocks before
/// the block's middle.
struct SpeechSequence {
  std::string voice;  ///< Of sounds that are no speech: their name.
  bool speech = true;
  std::size_t blocks = 0;
  std::vector<float> mel;  ///< blocks x speech::kConditionOfBlock: natural logarithms, as LogMel gives them.
  std::vector<float> mouth;    ///< blocks x speech_shapes(): weights.
  std::vector<float> closure;  ///< 1 while the lips meet for a P, B or M; before and after they come and go.
  std::vector<float> voiced;   ///< 1 while something is said.
};

struct SpeechDataset {
  std::size_t look_ahead = 1;
  std::vector<SpeechSequence> sequences;
};
struct SpeechData {
  SpeechDataset train, validation;
};

/// Has everybody speak. The same recipe gives the same bits with the same voices installed, on any number of
/// threads; 0 threads: one a core. Errors: the speaker's; cancelled. Cost: about a minute of one core for ten
/// minutes of speech.
[[nodiscard]] Result<SpeechData> make_speech_dataset(const SpeechDataRecipe& recipe,
                                                     const performer::Speaker& speaker,
                                                     const Progress& progress = no_progress,
                                                     unsigned threads = 0);

}  // namespace mien::synthetic
