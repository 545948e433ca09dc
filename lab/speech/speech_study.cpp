#include "lab/speech/speech_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "lab/speech/heard_frames.h"
#include "lab/speech/loudness_listener.h"
#include "lab/speech/sound_conditions.h"
#include "mien/performer/lines.h"
#include "mien/speech/heard_track.h"
#include "mien/speech/listeners.h"
#include "mien/synthetic/confidence_fit.h"
#include "mien/synthetic/speech/other_sounds.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

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

}  // namespace mien::lab
