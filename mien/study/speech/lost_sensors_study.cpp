#include "mien/study/speech/lost_sensors_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "mien/measure/metrics.h"
#include "mien/modalities/modalities.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/replay.h"
#include "mien/shaping/merge.h"
#include "mien/shaping/shaper.h"
#include "mien/speech/listeners.h"
#include "mien/speech/speech_tracker.h"
#include "mien/study/performance.h"
#include "mien/study/performers.h"
#include "mien/study/solve.h"
#include "mien/study/speech/speech_dataset.h"
#include "mien/study/speech/spoken_passage.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_session.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::study {
namespace {

using face::OutputFrame;
using face::Provenance;

constexpr bool is_of_mouth(std::size_t shape) {
  return face::kShapeRegions[shape] == face::ShapeRegion::mouth ||
         face::kShapeRegions[shape] == face::ShapeRegion::jaw;
}

/// The performance as the rig's devices feel it.
Result<virt::VirtualSession> feel(const sensor::Rig& rig, const face::Face& face, face::Motion motion,
                                  const Random& root) {
  if (!motion.has_head) motion = performer::with_head_motion(motion, root.fork("head"));
  if (sensor::kinds_of(rig).front() == "imu") {
    MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
    const auto begun =
        performer::with_prologue(motion, performer::PrologueKind::brief, root.fork("prologue"));
    MIEN_TRY_ASSIGN(const auto sites, virt::skin_sites(face, rig));
    return virt::play_devices(begun, sites, rig, faults, root.fork("devices"));
  }
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  const auto begun = performer::with_prologue(motion, performer::PrologueKind::brief, root.fork("prologue"),
                                              {.neutral_s = performer::kEyewearPrologue.neutral_s});
  MIEN_TRY_ASSIGN(const auto wearer, virt::seat_eyewear(face, rig, faults, root.fork("wearer")));
  return virt::play_eyewear(begun, wearer, rig, faults, root.fork("glasses"));
}

/// Blocks of a passage whose first sample is heard at `begin`, on the reference's clock.
class Microphone {
 public:
  Microphone(const SpokenPassage& passage, DeviceTime begin, std::unique_ptr<speech::SpeechTracker> tracker)
      : blocks_(blocks_of(passage.sound)), begin_(begin), tracker_(std::move(tracker)) {}
  /// What is heard by then.
  tracker::TickResult tick(DeviceTime frame, OutputFrame& out) {
    for (; next_ < blocks_.size(); ++next_) {
      const DeviceTime middle =
          begin_ + speech::kBlockDuration * static_cast<std::int64_t>(next_) + speech::kBlockDuration / 2;
      // A frame waits for the sample that reaches it.
      if (middle > frame + speech::kBlockDuration / 2) break;
      sensor::Sample sample;
      sample.kind = sensor::SampleKind::sound;
      sample.time = middle;
      const HostTime arrival(middle.time_since_epoch());
      lines_.add(arrival, sample);
      tracker_->add_with_payload(arrival, sample, speech::payload_of(blocks_[next_]));
    }
    return tracker_->tick(frame, lines_, out);
  }

 private:
  std::vector<speech::Block> blocks_;
  DeviceTime begin_;
  std::unique_ptr<speech::SpeechTracker> tracker_;
  sensor::TimeLines lines_{1, std::uint16_t{0}};
  std::size_t next_ = 0;
};

Result<Microphone> make_microphone(const SpokenPassage& passage, DeviceTime begin,
                                   const speech::SpeechNetworkFile& file) {
  sensor::Rig rig{.name = "microphone", .reference = "microphone"};
  rig.sensors.push_back({.name = "microphone", .kind = "speech", .role = "face"});
  MIEN_TRY_ASSIGN(auto tracker,
                  speech::SpeechTracker::create(rig, [file]() -> Result<std::unique_ptr<speech::Listener>> {
                    MIEN_TRY_ASSIGN(speech::SpeechNetwork network, speech::SpeechNetwork::create(file));
                    return std::make_unique<speech::LearnedListener>(std::move(network));
                  }));
  return Microphone(passage, begin, std::move(tracker));
}

/// The sensors' tracker, from which nothing comes for a while.
struct Sensors final : session::SampleConsumer {
  void add(HostTime arrival, const sensor::Sample& sample) override {
    if (!lost) tracker->add(arrival, sample);
  }
  void rebound(std::uint16_t sensor, const sensor::DeviceKey&, bool) override { tracker->forget(sensor); }
  std::unique_ptr<tracker::Tracker> tracker;
  bool lost = false;
};

struct Session {
  const LostSensorsScene& scene;
  const SpokenPassage& passage;
  const virt::VirtualSession& felt;
  DeviceTime lost_at, back_at;  // Equal: never.
};

/// What a session shows, frame by frame.
Result<std::vector<OutputFrame>> show(const Session& session, bool audio) {
  Sensors sensors;
  MIEN_TRY_ASSIGN(sensors.tracker, modalities::make_tracker(session.scene.rig, session.scene.model));
  guide_by_events(session.felt.events, *sensors.tracker);
  MIEN_TRY_ASSIGN(auto protocols, modalities::make_protocols());
  MIEN_TRY_ASSIGN(const auto receiver, session::Receiver::create(session.scene.rig, std::move(protocols)));
  MIEN_TRY_ASSIGN(Microphone microphone,
                  make_microphone(session.passage, session.felt.motion_start, session.scene.network));
  shaping::MergeSettings settings;
  settings.audio = audio;
  shaping::Merge merge({std::string(sensors.tracker->modality()), "speech"}, settings);
  shaping::Shaper shaper;
  std::vector<OutputFrame> frames;
  [[maybe_unused]] const bool whole = session::replay_samples(
      session.felt.entries, session.felt.ticks, *receiver, sensors, [&](const take::Tick& tick) {
        sensors.lost = tick.frame >= session.lost_at && tick.frame < session.back_at;
        OutputFrame sensed, heard, out;
        const auto by_sensors = sensors.tracker->tick(tick.frame, receiver->lines(), sensed);
        const auto by_sound = microphone.tick(tick.frame, heard);
        const std::array<shaping::Merge::Source, 2> sources = {
            shaping::Merge::Source{&sensed, by_sensors.sensors_present,
                                   by_sensors.explained ? &*by_sensors.explained : nullptr},
            shaping::Merge::Source{&heard, by_sound.sensors_present}};
        const std::size_t there = merge.apply(sources, out);
        shaper.apply(out, there);
        frames.push_back(out);
        return true;
      });
  return frames;
}

/// Sum of squares of the third differences of mouth and jaw in frames [first, last).
double jerk(const std::vector<OutputFrame>& frames, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t f = std::max<std::size_t>(first, 3); f < std::min(last, frames.size()); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!is_of_mouth(k)) continue;
      const auto w = [&](std::size_t back) { return double{frames[f - back].weights[k]}; };
      const double third = w(0) - 3 * w(1) + 3 * w(2) - w(3);
      sum += third * third;
    }
  return sum;
}

LostSensorsRow judge(const Session& session, const std::vector<OutputFrame>& shown,
                     const std::vector<OutputFrame>& steady, const std::vector<OutputFrame>& meanwhile,
                     const measure::Meter& meter) {
  const auto index_at = [&](DeviceTime time) {
    const auto found = std::ranges::lower_bound(shown, time, {}, &OutputFrame::time);
    return static_cast<std::size_t>(found - shown.begin());
  };
  constexpr std::size_t kHalf = 15;  // Frames of a quarter of a second.
  const std::size_t lost = index_at(session.lost_at), back = index_at(session.back_at);
  LostSensorsRow row;
  const auto claims = [](const OutputFrame& frame) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (is_of_mouth(k) &&
          (frame.provenance[k] == Provenance::measured || frame.provenance[k] == Provenance::interpolated ||
           frame.provenance[k] == Provenance::predicted))
        return true;
    return false;
  };
  std::size_t noticed = lost, recovered = back;
  while (noticed < shown.size() && claims(shown[noticed])) ++noticed;
  const auto as_steady = [&](std::size_t f) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (is_of_mouth(k) && shown[f].provenance[k] != steady[f].provenance[k]) return false;
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
  // All but mouth and jaw as in truth, so that nothing else counts.
  std::vector<face::BlendshapeWeights> truth, estimate;
  for (std::size_t f = lost; f < back; ++f) {
    truth.push_back(session.felt.truth[f].weights);
    estimate.push_back(truth.back());
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (is_of_mouth(k)) estimate.back()[k] = shown[f].weights[k];
  }
  const measure::Stretch stretch{truth, estimate};
  row.mouth_mm = meter.measure({&stretch, 1}).pve_mm.mean;
  return row;
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
                                                          const LostSensorsScene& scene,
                                                          const Speaker& speaker, const Progress& progress) {
  const std::vector<std::string> kinds = sensor::kinds_of(scene.rig);
  if (kinds.size() != 1 || (kinds.front() != "imu" && kinds.front() != "eyewear"))
    return fail(ErrorCode::bad_usage, "the study is of IMUs or of glasses", "rig " + scene.rig.name,
                "name a rig of one of them");
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
    Session session{scene, passage, felt, {}, {}};
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady_sensors, show(session, false));
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> steady_with_sound, show(session, true));
    session.lost_at = felt.motion_start - std::chrono::seconds(2);
    session.back_at = felt.motion_start + std::chrono::hours(1);
    MIEN_TRY_ASSIGN(const std::vector<OutputFrame> sound, show(session, true));
    session.lost_at = felt.motion_start + from_seconds(mid_sentence(passage, request.lost_s));
    session.back_at = session.lost_at + from_seconds(request.lost_s);
    const measure::Meter meter(person.face);
    const auto at = [&](DeviceTime time) {
      return static_cast<std::size_t>(std::ranges::lower_bound(steady_sensors, time, {}, &OutputFrame::time) -
                                      steady_sensors.begin());
    };
    const std::size_t first = at(session.lost_at - std::chrono::seconds(1)),
                      last = at(session.back_at + std::chrono::seconds(1));
    for (const bool audio : {false, true}) {
      MIEN_TRY_ASSIGN(const std::vector<OutputFrame> shown, show(session, audio));
      const auto& steady = audio ? steady_with_sound : steady_sensors;
      (audio ? out.heard : out.held) = judge(session, shown, steady, audio ? sound : steady, meter);
      (audio ? out.heard : out.held).audio = audio;
      (audio ? out.shown_heard : out.shown_held) = motion_of(shown, first, last);
    }
    std::vector<OutputFrame> truth(std::min(felt.truth.size(), steady_sensors.size()));
    for (std::size_t f = 0; f < truth.size(); ++f) {
      truth[f].weights = felt.truth[f].weights;
      truth[f].tongue_out = felt.truth[f].tongue_out;
    }
    out.truth = motion_of(truth, first, last);
    const double begin_s = to_seconds(session.lost_at - std::chrono::seconds(1) - felt.motion_start);
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
