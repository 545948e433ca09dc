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
#include "mien/synthetic/speech/closure_score.h"
#include "mien/synthetic/speech/speech_dataset.h"

namespace mien::lab {

struct SpeechRequest {
  int passages = 2;            ///< By each of voices_for(VoiceUse::test).
  double other_seconds = 600;  ///< Of each kind of sound that is no speech.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// What one way from sound to the mouth does with one kind of sound, frame by frame as a session shows it.
struct SpeechRow {
  std::string method;  ///< "phones", "learned".
  std::string sound;   ///< A condition or a language.
  synthetic::ClosureScore closures;
  /// Mean over passages of the correlation of jawOpen with the speaker's while something is said.
  double jaw_correlation = 0;
  /// What closures are shown late by, the median of those that were found, seconds.
  double late_s = 0;
};

/// How often a sound that is no speech moves the mouth.
struct OtherRow {
  std::string method, sound;
  double moving = 0;  ///< Share of frames in which a shape of mouth or jaw is above 0.05.
};

struct SpeechStudy {
  std::vector<SpeechRow> conditions, languages;
  std::vector<OtherRow> others;
};

/// PocketSphinx's phones and the network beside each other on the same sounds: virtual speakers whom nothing
/// was trained or chosen on, clean, in noise, rooms and poor microphones (made as waves, not in bands as
/// training does), in four languages; and sounds that are no speech. Sound is streamed block by block, and
/// frames are asked for as soon as a session's would be. Errors: the speaker's; not_found (PocketSphinx's
/// model); those of the network; cancelled.
[[nodiscard]] Result<SpeechStudy> study_speech(const SpeechRequest& request,
                                               const performer::Speaker& speaker,
                                               const speech::SpeechNetworkFile& network,
                                               const Progress& progress);

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
