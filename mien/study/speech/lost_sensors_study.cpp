#include "mien/study/speech/lost_sensors_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/measure/metrics.h"
#include "mien/speech/listener.h"
#include "mien/study/performance.h"
#include "mien/study/performers.h"
#include "mien/study/speech/mouth_score.h"
#include "mien/study/speech/speech_dataset.h"
#include "mien/study/speech/spoken_passage.h"

namespace mien::study {
namespace {

using face::OutputFrame;
using face::Provenance;

/// A session in which sensors are lost once.
struct Loss {
  const virt::VirtualSession& felt;
  DeviceTime lost_at, back_at;
};

/// Sum of squares of the third differences of mouth and jaw in frames [first, last).
double jerk(const std::vector<OutputFrame>& frames, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t f = std::max<std::size_t>(first, 3); f < std::min(last, frames.size()); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!speech::is_heard(k)) continue;
      const auto w = [&](std::size_t back) { return double{frames[f - back].weights[k]}; };
      const double third = w(0) - 3 * w(1) + 3 * w(2) - w(3);
      sum += third * third;
    }
  return sum;
}

LostSensorsRow judge(const Loss& loss, const std::vector<OutputFrame>& shown,
                     const std::vector<OutputFrame>& steady, const std::vector<OutputFrame>& meanwhile,
                     const measure::Meter& meter) {
  const auto index_at = [&](DeviceTime time) {
    const auto found = std::ranges::lower_bound(shown, time, {}, &OutputFrame::time);
    return static_cast<std::size_t>(found - shown.begin());
  };
  constexpr std::size_t kHalf = 15;  // Frames of a quarter of a second.
  const std::size_t lost = index_at(loss.lost_at), back = index_at(loss.back_at);
  LostSensorsRow row;
  const auto claims = [](const OutputFrame& frame) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (speech::is_heard(k) &&
          (frame.provenance[k] == Provenance::measured || frame.provenance[k] == Provenance::interpolated ||
           frame.provenance[k] == Provenance::predicted))
        return true;
    return false;
  };
  std::size_t noticed = lost, recovered = back;
  while (noticed < shown.size() && claims(shown[noticed])) ++noticed;
  const auto as_steady = [&](std::size_t f) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (speech::is_heard(k) && shown[f].provenance[k] != steady[f].provenance[k]) return false;
    return true;
  };
  while (recovered < std::min(shown.size(), steady.size()) && !as_steady(recovered)) ++recovered;
  // From a quarter of a second before sensors go or come to a quarter after another answers; each moment
  // beside whoever answers then.
  const auto ratio = [&](std::size_t at, std::size_t hands, const std::vector<OutputFrame>& before,
                         const std::vector<OutputFrame>& after) {
    const double usual = jerk(before, at - kHalf, hands) + jerk(after, hands, hands + kHalf);
    return usual == 0 ? 0 : std::sqrt(jerk(shown, at - kHalf, hands + kHalf) / usual);
  };
  row.jerk_ratio =
      std::max(ratio(lost, noticed, steady, meanwhile), ratio(back, recovered, meanwhile, steady));
  row.notice_s = static_cast<double>(noticed - lost) / kFrameRateHz;
  row.recover_s = static_cast<double>(recovered - back) / kFrameRateHz;
  std::vector<face::BlendshapeWeights> truth, during;
  for (std::size_t f = lost; f < back; ++f) {
    truth.push_back(loss.felt.truth[f].weights);
    during.push_back(shown[f].weights);
  }
  const measure::Stretch stretch{truth, during};
  row.mouth_mm = score_mouth(meter, {&stretch, 1}).mouth_mm;
  return row;
}

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

/// A moment in the middle of what is said, not in the pause between two lines.
double mid_sentence(const SpokenPassage& passage, double lost_s) {
  const double wanted_s = 0.4 * (passage.utterance.duration_s - lost_s);
  const auto spoken = [&](double t) {
    double voiced = 0;
    for (double s = t; s < t + lost_s; s += 0.02) voiced += passage.voiced_at(s) ? 1 : 0;
    return passage.voiced_at(t) ? voiced : 0;
  };
  double best_s = wanted_s;
  for (double t = wanted_s - 2; t < wanted_s + 2; t += 0.02)
    if (t > 1 && t + lost_s + 1 < passage.utterance.duration_s && spoken(t) > spoken(best_s)) best_s = t;
  return best_s;
}

}  // namespace

Result<std::vector<LostSensorsPerson>> study_lost_sensors(const LostSensorsRequest& request,
                                                          const SpokenScene& scene, const Speaker& speaker,
                                                          const Progress& progress) {
  MIEN_TRY(check_scene(scene));
  const std::vector<Voice> voices = voices_for(VoiceUse::test);
  std::vector<LostSensorsPerson> people(static_cast<std::size_t>(request.people));
  MIEN_TRY(for_each_performer(people.size(), request.threads, progress, [&](std::size_t p) -> Result<void> {
    LostSensorsPerson& out = people[p];
    out.seed = request.seed + p;
    const Random root = Random(out.seed).fork("lost");
    const Voice& voice = voices[p % voices.size()];
    out.voice = voice.name;
    const VirtualPerson person = draw_person(root);
    MIEN_TRY_ASSIGN(const SpokenPassage passage, speak_passage(speaker, voice.name, voice.language, root));
    MIEN_TRY_ASSIGN(const virt::VirtualSession felt, feel(scene.rig, person.face, passage.face, root));
    SpokenSession session{.scene = scene, .passage = passage, .felt = felt};
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady_sensors, frames_of(session, false));
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady_with_sound, frames_of(session, true));
    session.is_lost = [&](DeviceTime time) { return time >= felt.motion_start - std::chrono::seconds(2); };
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> sound, frames_of(session, true));
    Loss loss{.felt = felt};
    loss.lost_at = felt.motion_start + from_seconds(mid_sentence(passage, request.lost_s));
    loss.back_at = loss.lost_at + from_seconds(request.lost_s);
    session.is_lost = [&](DeviceTime time) { return time >= loss.lost_at && time < loss.back_at; };
    const measure::Meter meter(person.face);
    const auto at = [&](DeviceTime time) {
      return static_cast<std::size_t>(std::ranges::lower_bound(steady_sensors, time, {}, &OutputFrame::time) -
                                      steady_sensors.begin());
    };
    const std::size_t first = at(loss.lost_at - std::chrono::seconds(1)),
                      last = at(loss.back_at + std::chrono::seconds(1));
    for (const bool audio : {false, true}) {
      MIEN_TRY_ASSIGN(const std::vector<OutputFrame> shown, frames_of(session, audio));
      const auto& steady = audio ? steady_with_sound : steady_sensors;
      (audio ? out.heard : out.held) = judge(loss, shown, steady, audio ? sound : steady, meter);
      (audio ? out.heard : out.held).audio = audio;
      (audio ? out.shown_heard : out.shown_held) = motion_of(shown, first, last);
    }
    std::vector<OutputFrame> truth(std::min(felt.truth.size(), steady_sensors.size()));
    for (std::size_t f = 0; f < truth.size(); ++f) {
      truth[f].weights = felt.truth[f].weights;
      truth[f].tongue_out = felt.truth[f].tongue_out;
    }
    out.truth = motion_of(truth, first, last);
    const double begin_s = to_seconds(loss.lost_at - std::chrono::seconds(1) - felt.motion_start);
    const auto sample = static_cast<std::size_t>(std::max(0.0, begin_s) * speech::kRateHz);
    const auto count = static_cast<std::size_t>((request.lost_s + 2) * speech::kRateHz);
    out.sound.rate_hz = speech::kRateHz;
    for (std::size_t i = sample; i < std::min(passage.sound.size(), sample + count); ++i)
      out.sound.samples.push_back(passage.sound[i]);
    return {};
  }));
  return people;
}

}  // namespace mien::study
