#include "lab/speech/spoken_session.h"

#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "lab/speech/passage_microphone.h"
#include "mien/modalities/modalities.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/replay.h"
#include "mien/shaping/combined_tracker.h"
#include "mien/shaping/shaper.h"
#include "mien/solve/solve.h"
#include "mien/speech/listeners.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_session.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::lab {
namespace {

/// All samples go to the tracker but those that are lost.
struct LosingSensors final : session::SampleConsumer {
  explicit LosingSensors(shaping::CombinedTracker& all) : tracker(all) {}
  void add(HostTime arrival, const sensor::Sample& sample) override {
    if (!lost) tracker.add(arrival, sample);
  }
  void rebound(std::uint16_t sensor, const sensor::DeviceKey&, bool) override { tracker.forget(sensor); }
  shaping::CombinedTracker& tracker;
  bool lost = false;
};

Result<std::unique_ptr<PassageMicrophone>> make_microphone(const SpokenSession& session, Hearing hearing) {
  return PassageMicrophone::create(
      session.passage, session.felt.motion_start + session.lag,
      [&file = session.scene.network]() -> Result<std::unique_ptr<speech::Listener>> {
        MIEN_TRY_ASSIGN(speech::SpeechNetwork network, speech::SpeechNetwork::create(file));
        return std::make_unique<speech::LearnedListener>(std::move(network));
      },
      hearing == Hearing::retimed ? PassageMicrophone::Asked::as_told : PassageMicrophone::Asked::at_frame);
}

}  // namespace

Result<void> check_scene(const SpokenScene& scene) {
  const std::vector<std::string> kinds = sensor::kinds_of(scene.rig);
  if (kinds.size() == 1 && (kinds.front() == "imu" || kinds.front() == "eyewear")) return {};
  return fail(ErrorCode::bad_usage, "the study is of IMUs or of glasses alone, and brings its own microphone",
              "rig " + scene.rig.name, "name a rig of one of them");
}

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

Result<ShownSession> show(const SpokenSession& session, Hearing hearing) {
  const sensor::Rig& rig = session.scene.rig;
  std::vector<std::uint16_t> sensors(rig.sensors.size());
  std::iota(sensors.begin(), sensors.end(), std::uint16_t{0});
  MIEN_TRY_ASSIGN(auto sensing, modalities::make_tracker(rig, session.scene.model));
  MIEN_TRY_ASSIGN(auto hearing_tracker, make_microphone(session, hearing));
  PassageMicrophone& microphone = *hearing_tracker;
  std::vector<shaping::CombinedTracker::Part> parts;
  parts.push_back({std::move(sensing), std::move(sensors)});
  parts.push_back({std::move(hearing_tracker), {}});
  shaping::ShaperSettings settings;
  settings.merge.audio = hearing != Hearing::off;
  shaping::CombinedTracker tracker(std::move(parts), settings);
  solve::guide_by_events(session.felt.events, tracker);
  MIEN_TRY_ASSIGN(auto protocols, modalities::make_protocols());
  MIEN_TRY_ASSIGN(const auto receiver, session::Receiver::create(rig, std::move(protocols)));
  shaping::Shaper shaper;
  LosingSensors consumer(tracker);
  ShownSession shown;
  [[maybe_unused]] const bool whole = session::replay_samples(
      session.felt.entries, session.felt.ticks, *receiver, consumer, [&](const take::Tick& tick) {
        consumer.lost = session.is_lost && session.is_lost(tick.frame);
        microphone.hear(tick.frame);
        face::OutputFrame& frame = shown.frames.emplace_back();
        const auto told = tracker.tick(tick.frame, receiver->lines(), frame);
        shaper.apply(frame, told.sensors_present);
        shown.offset.push_back(tracker.retiming().offset());
        shown.believed.push_back(tracker.retiming().follows());
        return true;
      });
  return shown;
}

}  // namespace mien::lab
