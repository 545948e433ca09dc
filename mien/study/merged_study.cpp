#include "mien/study/merged_study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "mien/eyewear/eyewear_tracker.h"
#include "mien/imu/imu_tracker.h"
#include "mien/measure/evaluation.h"
#include "mien/modalities/modalities.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/replay.h"
#include "mien/shaping/merge.h"
#include "mien/study/draw_first.h"
#include "mien/study/performance.h"
#include "mien/study/performers.h"
#include "mien/study/solve.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/virtual/eyewear/eyewear_session.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/reception.h"

namespace mien::study {
namespace {

/// A rig of the sensors of one kind alone.
sensor::Rig only(const sensor::Rig& rig, std::string_view kind) {
  sensor::Rig out = rig;
  std::erase_if(out.sensors, [&](const sensor::Mount& mount) { return mount.kind != kind; });
  if (!out.find(out.reference) && !out.sensors.empty()) out.reference = out.sensors.front().name;
  return out;
}

/// A performance as IMUs and glasses feel it, received in one session.
Result<virt::VirtualSession> play_both(const MergedRequest& request, const MergedScene& scene,
                                       const VirtualPerson& person, const Random& root) {
  face::Motion motion = draw_motion(request.seconds, person.style, root);
  if (!motion.has_head) motion = performer::with_head_motion(motion, root.fork("head"));
  const performer::PrologueMotion begun = performer::with_prologue(
      motion, request.prologue, root.fork("prologue"), {.neutral_s = performer::kEyewearPrologue.neutral_s});
  const sensor::Rig imus = only(scene.rig, "imu"), glasses = only(scene.rig, "eyewear");
  const std::vector<Vec3> placement_m =
      virt::draw_placement(imus, 1e-3 * scene.imu_faults.mount_position_mm, root.fork("placement"));
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> sites, virt::skin_sites(person.face, imus, placement_m));
  MIEN_TRY_ASSIGN(virt::VirtualSession felt,
                  virt::play_devices(begun, sites, imus, scene.imu_faults, root.fork("devices")));
  MIEN_TRY_ASSIGN(const virt::EyewearWearer wearer,
                  virt::seat_eyewear(person.face, glasses, scene.eyewear_faults, root.fork("wearer")));
  MIEN_TRY_ASSIGN(virt::VirtualSession seen,
                  virt::play_eyewear(begun, wearer, glasses, scene.eyewear_faults, root.fork("glasses")));

  std::vector<virt::Datagram> arrived;
  for (virt::VirtualSession* one : {&felt, &seen})
    for (take::LogEntry& entry : one->entries)
      arrived.push_back(
          {entry.arrival, static_cast<std::uint16_t>(one == &felt ? 0 : 1), std::move(entry.bytes)});
  virt::sort_by_time(arrived);
  // The grid stands on an IMU's clock, so that the truth of the IMUs' own session stands on its ticks.
  std::map<DeviceTime, const take::TruthFrame*> truth_at;
  for (const take::TruthFrame& truth : felt.truth) truth_at.emplace(truth.time, &truth);
  virt::VirtualSession out;
  out.events = felt.events;
  out.motion_start = felt.motion_start;
  MIEN_TRY_ASSIGN(virt::Reception reception, virt::Reception::create(scene.rig));
  reception.log_all(std::move(arrived), out, [&](const take::Tick& tick, const sensor::TimeLines&) {
    const auto found = truth_at.find(tick.frame);
    take::TruthFrame& truth = out.truth.emplace_back();
    truth = {.time = tick.frame, .evaluated = false};
    if (found != truth_at.end()) truth = *found->second;
  });
  return out;
}

/// `count` of the rig's IMUs of the face.
std::vector<std::uint16_t> drawn_imus(const sensor::Rig& rig, int count, Random random) {
  std::vector<std::uint16_t> all;
  for (const std::uint16_t sensor : rig.face_sensors())
    if (rig.sensors[sensor].kind == "imu") all.push_back(sensor);
  draw_first(std::span(all), static_cast<std::size_t>(count), random);
  all.resize(std::min(all.size(), static_cast<std::size_t>(count)));
  return all;
}

/// Both trackers, each given what its sensors say.
struct Trackers final : session::SampleConsumer {
  static Result<Trackers> create(const MergedScene& scene) {
    Trackers out;
    const sensor::Rig imus = sensor::part_of(scene.rig, "imu"),
                      glasses = sensor::part_of(scene.rig, "eyewear");
    MIEN_TRY_ASSIGN(tracker::CausalTracker model,
                    tracker::CausalTracker::create(scene.imu, imus.face_sensor_names()));
    out.imu =
        std::make_unique<imu::ImuTracker>(imus, std::make_unique<tracker::CausalTracker>(std::move(model)));
    MIEN_TRY_ASSIGN(eyewear::MarkedFace marked, eyewear::MarkedFace::of(scene.eyewear, scene.markers));
    MIEN_TRY_ASSIGN(auto regressor,
                    eyewear::NetworkRegressor::create(scene.eyewear, eyewear::photo_sensor_names(glasses)));
    MIEN_TRY_ASSIGN(out.eyewear,
                    eyewear::EyewearTracker::create(glasses, std::move(marked), std::move(regressor)));
    for (const sensor::Mount& mount : scene.rig.sensors)
      out.owner.push_back(mount.kind == "imu" ? out.imu.get() : out.eyewear.get());
    return out;
  }
  void add(HostTime arrival, const sensor::Sample& sample) override {
    if (silent && std::ranges::find(lost, sample.sensor) != lost.end()) return;
    owner[sample.sensor]->add(arrival, sample);
  }
  void rebound(std::uint16_t sensor, const sensor::DeviceKey&, bool) override {
    imu->forget(sensor);
    eyewear->forget(sensor);
  }

  std::unique_ptr<tracker::Tracker> imu, eyewear;
  std::vector<tracker::Tracker*> owner;  // By the sensor's number.
  std::vector<std::uint16_t> lost;
  bool silent = false;  // Nothing comes from those any more.
};

Result<MergedPerson> answer(const MergedRequest& request, const MergedScene& scene, const face::Face& face,
                            const virt::VirtualSession& session, std::vector<std::uint16_t> lost) {
  MIEN_TRY_ASSIGN(Trackers trackers, Trackers::create(scene));
  trackers.lost = std::move(lost);
  guide_by_events(session.events, *trackers.imu);
  guide_by_events(session.events, *trackers.eyewear);
  MIEN_TRY_ASSIGN(auto protocols, modalities::make_protocols());
  MIEN_TRY_ASSIGN(const auto receiver, session::Receiver::create(scene.rig, std::move(protocols)));
  shaping::Merge merge({"imu", "eyewear"}, request.merge);

  MergedPerson out;
  std::vector<face::BlendshapeWeights> by_imu, by_eyewear, merged;
  std::array<std::optional<std::size_t>, face::kShapeCount> before;
  std::size_t evaluated = 0;
  [[maybe_unused]] const bool whole = session::replay_samples(
      session.entries, session.ticks, *receiver, trackers, [&](const take::Tick& tick) {
        std::array<face::OutputFrame, 2> frames;
        const tracker::TickResult imu = trackers.imu->tick(tick.frame, receiver->lines(), frames[0]);
        const tracker::TickResult eyewear = trackers.eyewear->tick(tick.frame, receiver->lines(), frames[1]);
        by_imu.push_back(frames[0].weights);
        by_eyewear.push_back(frames[1].weights);
        const auto source = [](face::OutputFrame& frame, const tracker::TickResult& result) {
          return shaping::Merge::Source{.frame = &frame,
                                        .sensors_present = result.sensors_present,
                                        .explained = result.explained ? &*result.explained : nullptr};
        };
        const std::array<shaping::Merge::Source, 2> sources = {source(frames[0], imu),
                                                               source(frames[1], eyewear)};
        face::OutputFrame one;
        merge.apply(sources, one);
        trackers.silent = tick.frame >= session.motion_start;
        const take::TruthFrame& truth = session.truth[merged.size()];
        const bool counts = truth.evaluated;
        merged.push_back(one.weights);
        evaluated += counts ? 1 : 0;
        for (std::size_t k = 0; k < face::kShapeCount; ++k) {
          const std::optional<std::size_t> who = merge.answers(k);
          if (counts) {
            out.confidence.add(one.confidence[k],
                               std::abs(one.weights[k] - truth.weights[k]) <= model::kConfidenceTolerance);
            out.by_eyewear[k] += who == std::size_t{1} ? 1 : 0;
            out.hand_overs += who != before[k] ? 1 : 0;
          }
          before[k] = who;
        }
        return true;
      });
  if (evaluated == 0) return fail(ErrorCode::not_found, "no frame of the performance is left to measure");
  for (double& share : out.by_eyewear) share /= static_cast<double>(evaluated);
  out.hand_overs *= kFrameRateHz / static_cast<double>(evaluated);
  const measure::Meter meter(face);
  out.imu = measure::measure_track(meter, session.truth, by_imu);
  out.eyewear = measure::measure_track(meter, session.truth, by_eyewear);
  out.merged = measure::measure_track(meter, session.truth, merged);
  return out;
}

}  // namespace

double MergedPerson::mae(const measure::Metrics& metrics) {
  double sum = 0;
  for (const measure::ShapeScore& shape : metrics.per_shape) sum += shape.mae;
  return sum / face::kShapeCount;
}

Result<std::vector<MergedPerson>> study_merged(const MergedRequest& request, const MergedScene& scene,
                                               const Progress& progress) {
  if (request.performers < 1 || !(request.seconds >= 1))
    return fail(ErrorCode::bad_usage, "the study needs somebody and a second of performance", "study merged");
  if (request.lost < 0 || std::cmp_greater(request.lost, only(scene.rig, "imu").face_sensors().size()))
    return fail(ErrorCode::bad_usage, "the rig has fewer IMUs of the face than are to be lost",
                "study merged");
  const auto reference = scene.rig.find(scene.rig.reference);
  if (!reference || scene.rig.sensors[*reference].kind != "imu")
    return fail(ErrorCode::bad_usage, "the frame grid of the rig is not an IMU's", "rig " + scene.rig.name,
                "name one as its reference");
  std::vector<MergedPerson> people(static_cast<std::size_t>(request.performers));
  MIEN_TRY(for_each_performer(people.size(), request.threads, progress, [&](std::size_t p) -> Result<void> {
    const Random root = Random(request.seed).fork("merged", p);
    const VirtualPerson person = draw_person(root);
    MIEN_TRY_ASSIGN(const virt::VirtualSession session, play_both(request, scene, person, root));
    MIEN_TRY_ASSIGN(people[p], answer(request, scene, person.face, session,
                                      drawn_imus(scene.rig, request.lost, root.fork("lost"))));
    return {};
  }));
  return people;
}

}  // namespace mien::study
