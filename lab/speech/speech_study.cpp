#include "lab/speech/speech_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/performer/lines.h"
#include "mien/solve/region_tally.h"
#include "mien/speech/articulator.h"
#include "mien/speech/listener.h"
#include "mien/speech/listeners.h"
#include "mien/speech/sound_block.h"
#include "mien/speech/spoken_mouth.h"
#include "mien/synthetic/confidence_fit.h"
#include "mien/synthetic/logistic_fit.h"
#include "mien/synthetic/speech/other_sounds.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/tracker/shape_confidence.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

/// Under what speech is heard in studies.
inline constexpr std::array<std::string_view, 7> kSoundConditions = {
    "clean", "noise at 20 dB", "noise at 10 dB", "noise at 5 dB", "room", "20 dB quieter", "telephone"};

/// The sound, speech::kRateHz, as one of kSoundConditions has it.
std::vector<float> disturbed(std::span<const float> sound, std::size_t condition, const Random& random) {
  std::vector<float> out(sound.begin(), sound.end());
  Random drawn = random.fork("condition", condition);
  const auto noise = [&](double snr_db) {
    const auto kind =
        static_cast<synthetic::OtherSound>(drawn.below(5));  // Breath and cough are for those who speak.
    synthetic::mix_at(snr_db, synthetic::make_other_sound(kind, out.size(), drawn.fork("noise")), out);
  };
  switch (condition) {
    case 1:
      noise(20);
      break;
    case 2:
      noise(10);
      break;
    case 3:
      noise(5);
      break;
    case 4:
      synthetic::put_in_room(0.4, 3, drawn.fork("room"), out);
      break;
    case 5:
      for (float& s : out) s *= 0.1F;
      break;
    case 6:
      synthetic::limit_band(300, 3400, out);
      break;
    default:
      break;
  }
  return out;
}

/// Told of each frame's time, and what is shown of whoever speaks; none while nobody does.
using SeeHeard = std::function<void(DeviceTime time, const std::optional<speech::Heard>& heard)>;
/// Streams a sound through a listener, begun anew, as a session hears it: 60 frames a second, each asked for
/// as soon as the block is there that reaches it.
void hear_frames(speech::Listener& listener, std::span<const speech::Block> blocks, const SeeHeard& see);

void hear_frames(speech::Listener& listener, std::span<const speech::Block> blocks, const SeeHeard& see) {
  listener.reset();
  speech::SpokenMouth mouth(listener.smoothing());
  DeviceTime block_time{};
  std::int64_t frame = 0;
  for (const speech::Block& block : blocks) {
    mouth.push(listener.push(block_time, block));
    // A frame is fired by the sample that reaches it, which is in the middle of its block.
    for (; DeviceTime(frame_offset(frame)) <= block_time + speech::kBlockDuration / 2; ++frame) {
      const DeviceTime time(frame_offset(frame));
      see(time, mouth.tick(time));
    }
    block_time += speech::kBlockDuration;
  }
}

/// What loudness alone tells, as puppets have it: the jaw opens with the level above a floor that follows the
/// room's (up to 0.4 at 30 dB), lips are closed where the level falls 12 dB below what it was lately. A
/// baseline.
class LoudnessListener final : public speech::Listener {
 public:
  speech::Heard push(DeviceTime time, const speech::Block& block) override;
  void reset() override;

 private:
  double floor_db_ = 0, peak_db_ = 0;
  bool begun_ = false;
};

speech::Heard LoudnessListener::push(DeviceTime time, const speech::Block& block) {
  // A block: how fast the floor rises and the peak falls, dB.
  constexpr double kRise_db = 0.1, kFall_db = 1;
  constexpr double kVoice_db = 10, kOpen_db = 30, kOpen = 0.4, kDip_db = 12;
  const double level_db = 20 * std::log10(std::max(1e-4, double{speech::loudness_of(block).rms}));
  if (!begun_) floor_db_ = peak_db_ = level_db;
  begun_ = true;
  floor_db_ = std::min(level_db, floor_db_ + kRise_db);
  peak_db_ = std::max(level_db, peak_db_ - kFall_db);
  speech::Heard heard{.time = time + speech::kBlockDuration / 2, .weights = {}};
  heard.voice = level_db > floor_db_ + kVoice_db ? 1 : 0;
  heard.weights[face::shape("jawOpen")] =
      static_cast<float>(kOpen * std::clamp((level_db - floor_db_ - kVoice_db) / kOpen_db, 0.0, 1.0));
  heard.closure = peak_db_ > floor_db_ + kVoice_db && level_db < peak_db_ - kDip_db ? 1 : 0;
  speech::close_lips(heard.closure, heard.weights);
  return heard;
}

void LoudnessListener::reset() {
  begun_ = false;
}

using speech::Heard;
using speech::Listener;

constexpr std::array<std::string_view, 4> kMethods = {"loudness", "phones", "learned", "both"};
constexpr float kMoves = 0.05F;

/// The network's mouth with the phones' closures added, at the time the phones are known for.
class BothListener final : public Listener {
 public:
  BothListener(std::unique_ptr<Listener> phones, std::unique_ptr<Listener> learned)
      : phones_(std::move(phones)), learned_(std::move(learned)) {}
  Heard push(DeviceTime time, const speech::Block& block) override {
    const Heard phones = phones_->push(time, block);
    track_.push(learned_->push(time, block));
    Heard heard = track_.at(phones.time).value_or(Heard{.time = phones.time, .weights = {}});
    heard.time = phones.time;
    heard.closure = std::max(heard.closure, phones.closure);
    speech::close_lips(heard.closure, heard.weights);
    return heard;
  }
  [[nodiscard]] double smoothing() const override { return learned_->smoothing(); }
  void reset() override {
    phones_->reset();
    learned_->reset();
    track_.clear();
  }

 private:
  std::unique_ptr<Listener> phones_, learned_;
  speech::HeardTrack track_;
};

using Listeners = std::array<std::unique_ptr<Listener>, kMethods.size()>;

Result<Listeners> make_listeners(const speech::SpeechNetworkFile& file) {
  MIEN_TRY_ASSIGN(auto one, speech::PhoneDecoder::create());
  MIEN_TRY_ASSIGN(auto two, speech::PhoneDecoder::create());
  MIEN_TRY_ASSIGN(auto network, speech::SpeechNetwork::create(file));
  MIEN_TRY_ASSIGN(auto other, speech::SpeechNetwork::create(file));
  return Listeners{
      std::make_unique<LoudnessListener>(), std::make_unique<speech::PhoneListener>(std::move(one)),
      std::make_unique<speech::LearnedListener>(std::move(network)),
      std::make_unique<BothListener>(std::make_unique<speech::PhoneListener>(std::move(two)),
                                     std::make_unique<speech::LearnedListener>(std::move(other)))};
}

/// What a session's frames show of a sound, 60 a second; neutral while nobody speaks.
struct Shown {
  std::vector<float> jaw, closure, most;
};

Shown show(Listener& listener, std::span<const speech::Block> blocks) {
  Shown shown;
  hear_frames(listener, blocks, [&](DeviceTime, const std::optional<Heard>& heard) {
    shown.jaw.push_back(heard ? heard->weights[face::shape("jawOpen")] : 0);
    shown.closure.push_back(heard ? heard->closure : 0);
    shown.most.push_back(heard ? std::ranges::max(heard->weights.values) : 0);
  });
  return shown;
}

/// A closure is shown where lips are closed by seven tenths.
std::vector<synthetic::Closure> closures_shown(const Shown& shown) {
  constexpr float kShown = 0.7F;
  return synthetic::stretches_above(shown.closure, kShown, 0, 1 / kFrameRateHz);
}

struct Tally {
  synthetic::ClosureScore closures;
  std::vector<double> correlations, late_s;

  void add(const Tally& other) {
    closures.add(other.closures);
    correlations.insert(correlations.end(), other.correlations.begin(), other.correlations.end());
    late_s.insert(late_s.end(), other.late_s.begin(), other.late_s.end());
  }
  [[nodiscard]] SpeechRow row(std::string_view method, std::string sound) const {
    SpeechRow row{.method = std::string(method), .sound = std::move(sound), .closures = closures};
    for (const double c : correlations) row.jaw_correlation += c / static_cast<double>(correlations.size());
    if (!late_s.empty()) {
      std::vector<double> sorted = late_s;
      std::ranges::sort(sorted);
      row.late_s = sorted[sorted.size() / 2];
    }
    return row;
  }
};

void score(const std::vector<synthetic::Closure>& truth, const Shown& shown, Tally& tally) {
  const std::vector<synthetic::Closure> heard = closures_shown(shown);
  tally.closures.add(synthetic::score_closures(truth, heard));
  for (const synthetic::Closure& one : heard) {
    const auto nearest = std::ranges::min_element(truth, {}, [&](const synthetic::Closure& t) {
      return std::abs(t.begin_s + t.end_s - one.begin_s - one.end_s);
    });
    if (nearest == truth.end()) continue;
    const double late_s = 0.5 * (one.begin_s + one.end_s - nearest->begin_s - nearest->end_s);
    if (std::abs(late_s) < 0.15) tally.late_s.push_back(late_s);
  }
}

using MethodTallies = std::array<Tally, kMethods.size()>;
/// Of one passage, a tally for each condition.
using PassageTallies = std::array<MethodTallies, kSoundConditions.size()>;

PassageTallies listen_to(const synthetic::SpokenPassage& passage, const Random& random,
                         Listeners& listeners) {
  PassageTallies tallies;
  for (std::size_t c = 0; c < kSoundConditions.size(); ++c) {
    const std::vector<speech::Block> blocks = synthetic::blocks_of(disturbed(passage.sound, c, random));
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      const Shown shown = show(*listeners[m], blocks);
      score(passage.closures, shown, tallies[c][m]);
      synthetic::Correlation jaw;
      for (std::size_t f = 0; f < std::min(shown.jaw.size(), passage.face.frames.size()); ++f) {
        const face::MotionFrame& truth = passage.face.frames[f];
        if (passage.voiced_at(truth.time_s))
          jaw.add(double{truth.weights[face::shape("jawOpen")]}, double{shown.jaw[f]});
      }
      tallies[c][m].correlations.push_back(jaw.r());
    }
  }
  return tallies;
}

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

Result<SpeechStudy> study_speech(const SpeechRequest& request, const performer::Speaker& speaker,
                                 const speech::SpeechNetworkFile& network, const Progress& progress) {
  constexpr double kSpeechShare = 0.7;
  const std::vector<synthetic::Voice> voices = synthetic::voices_for(synthetic::VoiceUse::test);
  const auto passages = static_cast<std::size_t>(request.passages);
  const Random root(request.seed);
  std::vector<PassageTallies> spoken(voices.size() * passages);
  MIEN_TRY(virt::for_each_performer(
      spoken.size(), request.threads,
      [&](double part, std::string_view what) { return progress(kSpeechShare * part, what); },
      [&](std::size_t i) -> Result<void> {
        const synthetic::Voice& voice = voices[i / passages];
        const Random random = root.fork("study " + voice.name, i % passages);
        MIEN_TRY_ASSIGN(const synthetic::SpokenPassage passage,
                        synthetic::speak_passage(speaker, voice.name, voice.language, random));
        MIEN_TRY_ASSIGN(Listeners listeners, make_listeners(network));
        spoken[i] = listen_to(passage, random, listeners);
        return {};
      }));
  SpeechStudy study;
  for (std::size_t c = 0; c < kSoundConditions.size(); ++c)
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      Tally all;
      for (const PassageTallies& one : spoken) all.add(one[c][m]);
      study.conditions.push_back(all.row(kMethods[m], std::string(kSoundConditions[c])));
    }
  const auto languages = performer::reading_languages();
  for (std::size_t l = 0; l <= languages.size(); ++l)
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      // Voices made of a person's recordings stand apart, last.
      Tally all;
      for (std::size_t i = 0; i < spoken.size(); ++i) {
        const synthetic::Voice& voice = voices[i / passages];
        const bool person = voice.name.contains(':');
        if (l == languages.size() ? person : !person && voice.language == l) all.add(spoken[i][0][m]);
      }
      study.languages.push_back(all.row(
          kMethods[m], l == languages.size() ? "en-us, a person's voice" : std::string(languages[l].voice)));
    }

  MIEN_TRY_ASSIGN(Listeners listeners, make_listeners(network));
  for (const LabelledSound& recorded : request.recorded) {
    MIEN_TRY_ASSIGN(const std::vector<float> sound, synthetic::resampled(recorded.sound));
    const std::vector<speech::Block> blocks = synthetic::blocks_of(sound);
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      Tally tally;
      score(recorded.closures, show(*listeners[m], blocks), tally);
      study.recorded.push_back(tally.row(kMethods[m], recorded.name));
    }
  }

  std::vector<std::array<double, kMethods.size()>> moving(synthetic::kOtherSoundNames.size());
  MIEN_TRY(virt::for_each_performer(
      moving.size(), request.threads,
      [&](double part, std::string_view what) {
        return progress(kSpeechShare + (1 - kSpeechShare) * part, what);
      },
      [&](std::size_t kind) -> Result<void> {
        MIEN_TRY_ASSIGN(Listeners own, make_listeners(network));
        const std::vector<float> sound =
            synthetic::make_other_sound(static_cast<synthetic::OtherSound>(kind),
                                        static_cast<std::size_t>(request.other_seconds * speech::kRateHz),
                                        root.fork("study other", kind));
        const std::vector<speech::Block> blocks = synthetic::blocks_of(sound);
        for (std::size_t m = 0; m < kMethods.size(); ++m) {
          const Shown shown = show(*own[m], blocks);
          const auto above = std::ranges::count_if(shown.most, [](float w) { return w > kMoves; });
          moving[kind][m] =
              static_cast<double>(above) / static_cast<double>(std::max<std::size_t>(1, shown.most.size()));
        }
        return {};
      }));
  for (std::size_t kind = 0; kind < moving.size(); ++kind)
    for (std::size_t m = 0; m < kMethods.size(); ++m)
      study.others.push_back(
          {std::string(kMethods[m]), std::string(synthetic::kOtherSoundNames[kind]), moving[kind][m]});
  return study;
}

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
