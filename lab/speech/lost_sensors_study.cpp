#include "lab/speech/lost_sensors_study.h"

#include <algorithm>
#include <utility>

#include "mien/measure/metrics.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using face::OutputFrame;

/// What the session shows, with a microphone or without.
Result<std::vector<OutputFrame>> frames_of(const SpokenSession& session, bool audio) {
  MIEN_TRY_ASSIGN(ShownSession shown, show(session, audio ? Hearing::as_it_comes : Hearing::off));
  return std::move(shown.frames);
}

face::Motion motion_of(const std::vector<OutputFrame>& shown, std::size_t first, std::size_t last) {
  face::Motion motion{.name = "lost sensors", .frames = {}};
  for (std::size_t f = first; f < std::min(last, shown.size()); ++f) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = static_cast<double>(f - first) / kFrameRateHz;
    frame.weights = shown[f].weights;
    frame.tongue_out = shown[f].tongue_out;
  }
  return motion;
}

}  // namespace

Result<std::vector<LostSensorsPerson>> study_lost_sensors(const LostSensorsRequest& request,
                                                          const SpokenScene& scene,
                                                          const performer::Speaker& speaker,
                                                          const Progress& progress) {
  MIEN_TRY(check_scene(scene));
  const std::vector<synthetic::Voice> voices = synthetic::voices_for(synthetic::VoiceUse::test);
  std::vector<LostSensorsPerson> people(static_cast<std::size_t>(request.people));
  MIEN_TRY(
      virt::for_each_performer(people.size(), request.threads, progress, [&](std::size_t p) -> Result<void> {
        LostSensorsPerson& out = people[p];
        out.seed = request.seed + p;
        const Random root = Random(out.seed).fork("lost");
        const synthetic::Voice& voice = voices[p % voices.size()];
        out.voice = voice.name;
        const virt::VirtualPerson person = virt::draw_person(root);
        MIEN_TRY_ASSIGN(const synthetic::SpokenPassage passage,
                        synthetic::speak_passage(speaker, voice.name, voice.language, root));
        MIEN_TRY_ASSIGN(const virt::VirtualSession felt, feel(scene.rig, person.face, passage.face, root));
        SpokenSession session{.scene = scene, .passage = passage, .felt = felt};
        MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady_sensors, frames_of(session, false));
        MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady_with_sound, frames_of(session, true));
        session.is_lost = [&](DeviceTime time) {
          return time >= felt.motion_start - std::chrono::seconds(2);
        };
        MIEN_TRY_ASSIGN(const std::vector<OutputFrame> sound, frames_of(session, true));
        const DeviceTime lost_at = felt.motion_start + from_seconds(mid_sentence(passage, request.lost_s));
        const DeviceTime back_at = lost_at + from_seconds(request.lost_s);
        session.is_lost = [&](DeviceTime time) { return time >= lost_at && time < back_at; };
        const measure::Meter meter(person.face);
        const auto at = [&](DeviceTime time) {
          return static_cast<std::size_t>(
              std::ranges::lower_bound(steady_sensors, time, {}, &OutputFrame::time) -
              steady_sensors.begin());
        };
        const std::size_t first = at(lost_at - std::chrono::seconds(1)),
                          last = at(back_at + std::chrono::seconds(1));
        std::vector<face::BlendshapeWeights> true_weights;
        for (const take::TruthFrame& frame : felt.truth) true_weights.push_back(frame.weights);
        for (const bool audio : {false, true}) {
          MIEN_TRY_ASSIGN(const std::vector<OutputFrame> shown, frames_of(session, audio));
          const auto& steady = audio ? steady_with_sound : steady_sensors;
          (audio ? out.heard : out.held) = {
              .audio = audio,
              .over = judge_hand_over({.lost = at(lost_at), .back = at(back_at)},
                                      {.shown = shown,
                                       .steady = steady,
                                       .meanwhile = audio ? sound : steady,
                                       .truth = true_weights},
                                      meter)};
          (audio ? out.shown_heard : out.shown_held) = motion_of(shown, first, last);
        }
        std::vector<OutputFrame> truth(std::min(felt.truth.size(), steady_sensors.size()));
        for (std::size_t f = 0; f < truth.size(); ++f) {
          truth[f].weights = felt.truth[f].weights;
          truth[f].tongue_out = felt.truth[f].tongue_out;
        }
        out.truth = motion_of(truth, first, last);
        const double begin_s = to_seconds(lost_at - std::chrono::seconds(1) - felt.motion_start);
        const auto sample = static_cast<std::size_t>(std::max(0.0, begin_s) * speech::kRateHz);
        const auto count = static_cast<std::size_t>((request.lost_s + 2) * speech::kRateHz);
        out.sound.rate_hz = speech::kRateHz;
        for (std::size_t i = sample; i < std::min(passage.sound.size(), sample + count); ++i)
          out.sound.samples.push_back(passage.sound[i]);
        return {};
      }));
  return people;
}

}  // namespace mien::lab
