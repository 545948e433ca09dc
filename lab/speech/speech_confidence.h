#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/model/confidence.h"
#include "mien/performer/speaker.h"
#include "mien/solve/reliability.h"
#include "mien/speech/speech_network.h"
#include "mien/synthetic/speech/speech_dataset.h"

namespace mien::lab {

/// Who is listened to, to learn what a network of speech is worth.
struct HeardPeople {
  synthetic::VoiceUse voices = synthetic::VoiceUse::confidence;
  int passages = 2;  ///< By each voice, each under all of kSoundConditions.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// The table of a network's answers, mouth and jaw, and its regions' maps, on frames in which somebody speaks
/// as a session shows them. A shape's coverage is whether there is a voice (speech::Heard::voice). People
/// move as performers of styles of their own do, so what one does not hear of them counts as error. Errors:
/// the speaker's, the network's; cancelled.
[[nodiscard]] Result<model::ConfidenceTable> measure_speech_confidence(
    const speech::SpeechNetworkFile& network, const HeardPeople& people, const performer::Speaker& speaker,
    const Progress& progress);

/// How true the confidence of mouth and jaw is under one of kSoundConditions.
struct SpeechConfidenceRow {
  std::string sound;
  std::size_t frames = 0;
  solve::Reliability mouth, jaw;
};
/// What the network's table says of people whom it was not measured on. None for a network without a table.
/// Errors: as measure_speech_confidence().
[[nodiscard]] Result<std::vector<SpeechConfidenceRow>> study_speech_confidence(
    const speech::SpeechNetworkFile& network, const HeardPeople& people, const performer::Speaker& speaker,
    const Progress& progress);

}  // namespace mien::lab
