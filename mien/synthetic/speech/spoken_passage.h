#pragma once

#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/performer/speaker.h"
#include "mien/speech/sound_block.h"

namespace mien::synthetic {

/// A time in which the lips meet for a P, B or M, seconds.
struct Closure {
  double begin_s = 0, end_s = 0;
};

/// When the lips of whoever says this meet, in order: as performer::perform_speech has it, the middle three
/// fifths of the sound, 40 ms at least.
[[nodiscard]] std::vector<Closure> closures_of(const performer::Utterance& utterance);

/// Somebody speaks: what is heard, and what the face does meanwhile.
struct SpokenPassage {
  performer::Utterance utterance;
  std::vector<float> sound;  ///< speech::kRateHz, -1 to 1.
  face::Motion face;         ///< 60 Hz, of a performer of a style of their own.
  std::vector<Closure> closures;

  /// Whether something is being said at that time.
  [[nodiscard]] bool voiced_at(double time_s) const;
};

/// Three lines by one voice, or as many as take `at_least_s`, with pauses about them; half of them of words
/// that do not exist, of kNoLanguage all. `language`: the voice's, of reading_languages(), or that. Errors:
/// the speaker's.
[[nodiscard]] Result<SpokenPassage> speak_passage(const performer::Speaker& speaker, const std::string& voice,
                                                  std::size_t language, const Random& random,
                                                  double at_least_s = 0);

/// Sound of any rate at speech::kRateHz, as long as it was. Errors: BlockMaker's.
[[nodiscard]] Result<std::vector<float>> resampled(const Sound& sound);

/// The sound as blocks, the last one filled up with silence; clipped at full scale.
[[nodiscard]] std::vector<speech::Block> blocks_of(std::span<const float> sound);

}  // namespace mien::synthetic
