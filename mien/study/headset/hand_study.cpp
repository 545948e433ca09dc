#include "mien/study/headset/hand_study.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "mien/headset/headset_tracker.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig_part.h"
#include "mien/shaping/combined_tracker.h"
#include "mien/shaping/shaper.h"
#include "mien/speech/listener.h"
#include "mien/speech/listeners.h"
#include "mien/study/headset/headset_dataset.h"
#include "mien/study/headset/seen_film.h"
#include "mien/study/performers.h"
#include "mien/study/speech/passage_microphone.h"
#include "mien/study/speech/speech_dataset.h"
#include "mien/study/speech/spoken_passage.h"
#include "mien/virtual/headset/headset_wearer.h"

namespace mien::study {
namespace {

using face::OutputFrame;

/// Frames at rest, a second; of speech before the hand, and after it.
constexpr int kAtRest = 60;
constexpr std::size_t kBefore = 150, kAfter = 90;
/// Frames of a picture before the hand.
constexpr std::size_t kShownBefore = 30;

/// Somebody speaks before cameras.
struct Spoken {
  const HandScene& scene;
  const SpokenPassage& passage;
  DeviceTime begin;  ///< The passage's, on the film's clock, whose first frame is at 0.
};

enum class Senses : std::uint8_t {
  eyes,  ///< The cameras alone.
  both,
  ears,  ///< The microphone alone, once the face was at rest.
};

/// What a session shows of the film, one of all a frame.
Result<std::vector<OutputFrame>> show(const Spoken& spoken, const SeenFilm& film, Senses senses) {
  const sensor::Rig& rig = spoken.scene.rig;
  MIEN_TRY_ASSIGN(auto seeing, headset::HeadsetTracker::create(rig, spoken.scene.model));
  const auto make_listener = [&]() -> Result<std::unique_ptr<speech::Listener>> {
    MIEN_TRY_ASSIGN(speech::SpeechNetwork network, speech::SpeechNetwork::create(spoken.scene.network));
    return std::make_unique<speech::LearnedListener>(std::move(network));
  };
  MIEN_TRY_ASSIGN(auto hearing, PassageMicrophone::create(spoken.passage, spoken.begin, make_listener,
                                                          PassageMicrophone::Asked::at_frame));
  PassageMicrophone& microphone = *hearing;
  std::vector<shaping::CombinedTracker::Part> parts;
  parts.push_back({std::move(seeing), sensor::sensors_of(rig, "camera")});
  parts.push_back({std::move(hearing), {}});
  shaping::ShaperSettings settings;
  settings.merge.audio = senses != Senses::eyes;
  shaping::CombinedTracker tracker(std::move(parts), settings);
  const DeviceTime first;
  // Two frames less, so that the neutral is in force when the motion begins.
  tracker.guide(tracker::Step::neutral, first, first + frame_offset(kAtRest - 2));
  shaping::Shaper shaper;
  sensor::TimeLines lines(rig.sensors.size(), rig.find(rig.reference));
  std::vector<OutputFrame> shown(film.truth.size());
  for (std::size_t f = 0; f < shown.size(); ++f) {
    const DeviceTime now(frame_offset(static_cast<std::int64_t>(f)));
    if (senses != Senses::ears || f < std::size_t{kAtRest})
      deliver(film.records[f], now, rig, {}, lines, tracker);
    microphone.hear(now);
    const auto told = tracker.tick(now, lines, shown[f]);
    shaper.apply(shown[f], told.sensors_present);
  }
  return shown;
}

/// The part of the motion from its frame `first` on, `count` frames, beginning at time 0.
face::Motion part_of(const face::Motion& motion, std::size_t first, std::size_t count) {
  face::Motion part{.name = motion.name, .frames = {}};
  for (std::size_t f = first; f < std::min(first + count, motion.frames.size()); ++f) {
    part.frames.push_back(motion.frames[f]);
    part.frames.back().time_s -= motion.frames[first].time_s;
  }
  return part;
}

/// What is heard of it from `from_s` on; silence where nothing is left.
Sound sound_of(const SpokenPassage& passage, double from_s, double duration_s) {
  const auto samples = [](double s) { return static_cast<std::ptrdiff_t>(std::lround(s * speech::kRateHz)); };
  Sound sound{.rate_hz = static_cast<std::uint32_t>(speech::kRateHz), .samples = {}};
  const auto end = static_cast<std::ptrdiff_t>(passage.sound.size()), first = samples(from_s);
  for (std::ptrdiff_t i = first; i < first + samples(duration_s); ++i)
    sound.samples.push_back(i >= 0 && i < end ? passage.sound[static_cast<std::size_t>(i)] : 0);
  return sound;
}

/// What the hand moves of what claims to be sensed.
void measure_change(const Unsensed& hand, const std::vector<OutputFrame>& shown,
                    const std::vector<OutputFrame>& steady, HandRow& row) {
  double sum = 0, count = 0;
  for (std::size_t f = hand.lost; f < hand.back; ++f) {
    double of_frame = 0, shapes = 0;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!speech::is_heard(k) || !claims_to_be_sensed(shown[f].provenance[k])) continue;
      of_frame += std::abs(double{shown[f].weights[k]} - double{steady[f].weights[k]});
      ++shapes;
    }
    if (shapes > 0) row.last_change = of_frame / shapes;
    sum += of_frame;
    count += shapes;
  }
  row.mouth_change = count > 0 ? sum / count : 0;
}

Result<void> look_at_person(const HandStudyRequest& request, const HandScene& scene, const Speaker& speaker,
                            const virt::HeadsetFaults& faults, const Voice& voice, HandPerson& out) {
  const Random root = Random(out.seed).fork("hand");
  out.voice = voice.name;
  MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer, virt::draw_headset_wearer(scene.rig, faults, root));
  MIEN_TRY_ASSIGN(const SpokenPassage passage, speak_passage(speaker, voice.name, voice.language, root));
  const auto frames_of = [](double s) { return static_cast<std::size_t>(std::lround(s * kFrameRateHz)); };
  const std::size_t hand_frames = frames_of(request.hand_s);
  const std::size_t hand_at = frames_of(mid_sentence(passage, request.hand_s));
  // A passage that is too short begins and ends at rest.
  const std::size_t first = hand_at - std::min(hand_at, kBefore);
  const Unsensed hand{.lost = kAtRest + hand_at - first, .back = kAtRest + hand_at - first + hand_frames};
  const std::size_t frames = hand_at - first + hand_frames + kAfter;
  const face::Motion motion = part_of(passage.face, first, frames);
  const Spoken spoken{
      .scene = scene,
      .passage = passage,
      .begin = DeviceTime(frame_offset(kAtRest) - from_seconds(passage.face.frames[first].time_s))};
  HeadsetTakeRequest take{.frames = static_cast<int>(frames),
                          .neutral_frames = kAtRest,
                          .rate_hz = kFrameRateHz,
                          .fails_from = static_cast<int>(hand.lost),
                          .fails_to = static_cast<int>(hand.back),
                          .side = static_cast<int>(scene.model->network().architecture().side)};
  const Random seat = root.fork("headset");
  MIEN_TRY_ASSIGN(const SeenFilm free,
                  look_at(film_wearer(wearer, faults, motion, take, seat), scene.rig, *scene.model));
  take.failure = virt::HeadsetFailure::hand;
  std::vector<FilmFrame> film = film_wearer(wearer, faults, motion, take, seat);
  MIEN_TRY_ASSIGN(const SeenFilm hidden, look_at(film, scene.rig, *scene.model));

  std::vector<face::BlendshapeWeights> truth(hidden.truth.size());
  for (std::size_t f = 0; f < truth.size(); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k) truth[f][k] = hidden.truth[f].weights[k];
  const measure::Meter meter(wearer.face);
  MIEN_TRY_ASSIGN(const std::vector<OutputFrame> sound, show(spoken, hidden, Senses::ears));
  std::vector<OutputFrame> held, heard;
  for (const bool audio : {false, true}) {
    const Senses senses = audio ? Senses::both : Senses::eyes;
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady, show(spoken, free, senses));
    MIEN_TRY_ASSIGN(std::vector<OutputFrame> shown, show(spoken, hidden, senses));
    HandRow& row = audio ? out.heard : out.held;
    row.over = judge_hand_over(
        hand, {.shown = shown, .steady = steady, .meanwhile = audio ? sound : steady, .truth = truth}, meter);
    measure_change(hand, shown, steady, row);
    (audio ? heard : held) = std::move(shown);
  }
  out.sound =
      sound_of(passage,
               to_seconds(DeviceTime(frame_offset(static_cast<std::int64_t>(hand.lost - kShownBefore))) -
                          spoken.begin),
               static_cast<double>(film.size() - hand.lost + kShownBefore) / kFrameRateHz);
  std::size_t mouth = 0;
  while (mouth + 1 < scene.rig.sensors.size() && scene.rig.sensors[mouth].site != "mouth") ++mouth;
  for (std::size_t f = hand.lost - kShownBefore; f < film.size(); ++f) {
    HandMoment& moment = out.moments.emplace_back();
    moment.time_s = (static_cast<double>(f) - static_cast<double>(hand.lost)) / kFrameRateHz;
    moment.mouth_view = std::move(film[f].views[mouth]);
    moment.truth.weights = truth[f];
    moment.truth.tongue_out = hidden.truth[f].tongue_out;
    moment.held = held[f];
    moment.heard = heard[f];
  }
  return {};
}

}  // namespace

Result<std::vector<HandPerson>> study_hand(const HandStudyRequest& request, const HandScene& scene,
                                           const Speaker& speaker, const Progress& progress) {
  if (sensor::kinds_of(scene.rig) != std::vector<std::string>{"camera"})
    return fail(ErrorCode::bad_usage, "the study is of cameras alone, and brings its own microphone",
                "rig " + scene.rig.name, "name a rig of cameras, as rigs/headset.toml");
  if (request.people < 1 || !(request.hand_s >= 0.2 && request.hand_s <= 4))
    return fail(ErrorCode::out_of_range, "a study needs somebody, and a hand of 0.2 to 4 s");
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults,
                  virt::parse_headset_faults(scene.rig.faults_toml, scene.rig.name));
  MIEN_TRY(virt::check_network_views(scene.rig));
  const std::vector<Voice> voices = voices_for(VoiceUse::test);
  std::vector<HandPerson> people(static_cast<std::size_t>(request.people));
  MIEN_TRY(for_each_performer(people.size(), request.threads, progress, [&](std::size_t p) {
    people[p].seed = request.seed + p;
    return look_at_person(request, scene, speaker, faults, voices[p % voices.size()], people[p]);
  }));
  return people;
}

}  // namespace mien::study
