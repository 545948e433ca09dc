#include "lab/speech/speech_confidence.h"

#include <algorithm>
#include <array>
#include <utility>

#include "lab/speech/heard_frames.h"
#include "lab/speech/sound_conditions.h"
#include "mien/core/time.h"
#include "mien/solve/region_tally.h"
#include "mien/speech/listeners.h"
#include "mien/synthetic/confidence_fit.h"
#include "mien/synthetic/logistic_fit.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/tracker/shape_confidence.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

constexpr auto kMouth = static_cast<std::size_t>(face::ShapeRegion::mouth),
               kJaw = static_cast<std::size_t>(face::ShapeRegion::jaw);

/// A frame in which somebody speaks.
struct HeardFrame {
  float voice = 0;
  face::BlendshapeWeights answer, truth;
};
/// Of one passage, under each of kSoundConditions.
using HeardPassage = std::array<std::vector<HeardFrame>, kSoundConditions.size()>;

tracker::Coverage coverage_of(const HeardFrame& frame) {
  tracker::Coverage coverage{};
  coverage.fill(frame.voice);
  return coverage;
}

std::vector<HeardFrame> listen(speech::Listener& listener, std::span<const speech::Block> blocks,
                               const face::MotionCurve& truth) {
  std::vector<HeardFrame> frames;
  hear_frames(listener, blocks, [&](DeviceTime time, const std::optional<speech::Heard>& heard) {
    if (heard)
      frames.push_back({heard->voice, heard->weights, truth.at(to_seconds(time.time_since_epoch())).weights});
  });
  return frames;
}

Result<std::vector<HeardPassage>> listen_to(const speech::SpeechNetworkFile& network,
                                            const HeardPeople& people, const performer::Speaker& speaker,
                                            const Progress& progress) {
  const std::vector<synthetic::Voice> voices = synthetic::voices_for(people.voices);
  const auto passages = static_cast<std::size_t>(people.passages);
  std::vector<HeardPassage> heard(voices.size() * passages);
  const Random root = Random(people.seed).fork("heard people");
  MIEN_TRY(
      virt::for_each_performer(heard.size(), people.threads, progress, [&](std::size_t i) -> Result<void> {
        const synthetic::Voice& voice = voices[i / passages];
        const Random random = root.fork(voice.name, i % passages);
        MIEN_TRY_ASSIGN(const synthetic::SpokenPassage passage,
                        synthetic::speak_passage(speaker, voice.name, voice.language, random));
        MIEN_TRY_ASSIGN(speech::SpeechNetwork own, speech::SpeechNetwork::create(network));
        speech::LearnedListener listener(std::move(own));
        const face::MotionCurve truth(passage.face);
        for (std::size_t c = 0; c < kSoundConditions.size(); ++c)
          heard[i][c] = listen(listener, synthetic::blocks_of(disturbed(passage.sound, c, random)), truth);
        return {};
      }));
  return heard;
}

}  // namespace

Result<model::ConfidenceTable> measure_speech_confidence(const speech::SpeechNetworkFile& network,
                                                         const HeardPeople& people,
                                                         const performer::Speaker& speaker,
                                                         const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<HeardPassage> heard, listen_to(network, people, speaker, progress));
  synthetic::ConfidenceFit fit;
  for (const HeardPassage& passage : heard)
    for (const std::vector<HeardFrame>& frames : passage) {
      for (const HeardFrame& frame : frames)
        for (std::size_t k = 0; k < face::kShapeCount; ++k)
          if (speech::is_heard(k)) fit.add(k, frame.voice, frame.answer[k], frame.truth[k]);
      fit.end_person();
    }
  model::ConfidenceTable table = fit.table();
  table.people = synthetic::voices_for(people.voices).size();
  table.seed = people.seed;
  const tracker::ShapeConfidence confidence(table);
  std::array<synthetic::LogisticFit, face::kShapeRegionCount> fits;
  for (const HeardPassage& passage : heard)
    for (const std::vector<HeardFrame>& frames : passage)
      for (const HeardFrame& frame : frames) {
        const auto scores = confidence.region_scores(coverage_of(frame), frame.answer);
        const auto within = solve::regions_within(frame.answer, frame.truth);
        for (const std::size_t r : {kMouth, kJaw}) fits[r].add(scores[r], within[r]);
      }
  model::RegionMaps& maps = table.regions.emplace();
  for (const std::size_t r : {kMouth, kJaw}) maps[r] = fits[r].solve();
  return table;
}

Result<std::vector<SpeechConfidenceRow>> study_speech_confidence(const speech::SpeechNetworkFile& network,
                                                                 const HeardPeople& people,
                                                                 const performer::Speaker& speaker,
                                                                 const Progress& progress) {
  std::vector<SpeechConfidenceRow> rows;
  if (!network.confidence) return rows;
  MIEN_TRY_ASSIGN(const std::vector<HeardPassage> heard, listen_to(network, people, speaker, progress));
  const tracker::ShapeConfidence confidence(network.confidence);
  for (std::size_t c = 0; c < kSoundConditions.size(); ++c) {
    SpeechConfidenceRow& row = rows.emplace_back();
    row.sound = kSoundConditions[c];
    for (const HeardPassage& passage : heard)
      for (const HeardFrame& frame : passage[c]) {
        face::OutputFrame out;
        out.weights = frame.answer;
        confidence.write(coverage_of(frame), out);
        const auto within = solve::regions_within(frame.answer, frame.truth);
        row.mouth.add(out.region_confidence[kMouth], within[kMouth]);
        row.jaw.add(out.region_confidence[kJaw], within[kJaw]);
        ++row.frames;
      }
  }
  return rows;
}

}  // namespace mien::lab
