#include "lab/imu/hours_study.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "lab/imu/observed_rotations.h"
#include "mien/core/sha256.h"
#include "mien/core/units.h"
#include "mien/imu/pipeline.h"
#include "mien/measure/metrics.h"
#include "mien/measure/weight_errors.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/imu/streamed_session.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

/// Vertex errors are measured on every such frame, and the filter's consistency too.
constexpr std::size_t kSampledFrames = 20;

using Weights = face::BlendshapeWeights;

void put_rotation(const Quat& rotation, model::SensorFeature& feature) {
  feature.rotation = wxyz_of(canonical(rotation));
  feature.has_rotation = true;
}

/// One way to the weights, and what it errs in the present piece.
struct HoursWay {
  tracker::CausalTracker tracker;
  face::OutputFrame answer;
  measure::WeightErrors errors = {};
  std::vector<Weights> sampled;

  void step(const model::FeatureFrame& features) { tracker.step(features, answer); }
};

/// Minutes that all performers have performed, and whether to stop.
struct Clock {
  std::atomic<std::size_t> minutes = 0;
  std::atomic<bool> stopped = false;
};

/// Mean square of rotations' errors.
struct RotationErrors {
  double squares_rad2 = 0;
  std::size_t count = 0;

  void add(const Vec3& error_rad) {
    squares_rad2 += error_rad.squaredNorm();
    ++count;
  }
  [[nodiscard]] double rms_deg() const {
    return count > 0 ? kDegPerRad * std::sqrt(squares_rad2 / static_cast<double>(count)) : 0;
  }
};

/// What each way answers for the shapes of held expressions, each expression's mean over frames of the
/// present piece.
class ShapeMeans {
 public:
  explicit ShapeMeans(std::span<const performer::HeldExpression> held) : held_(held), means_(held.size()) {}

  /// A frame of the expression `h`.
  void add(std::size_t h, std::span<const HoursWay> ways) {
    ++means_[h].frames;
    for (std::size_t way = 0; way < ways.size(); ++way)
      for (const std::size_t k : held_[h].shapes)
        means_[h].sums[way] += ways[way].answer.weights[k] / static_cast<double>(held_[h].shapes.size());
  }
  /// Of expressions with frames, in their order; the next piece begins.
  [[nodiscard]] std::vector<HoursErrors> take() {
    std::vector<HoursErrors> out;
    for (Mean& mean : means_) {
      const auto frames = static_cast<double>(mean.frames);
      if (mean.frames > 0)
        out.push_back(
            {mean.sums[0] / frames, mean.sums[1] / frames, mean.sums[2] / frames, mean.sums[3] / frames});
      mean = {};
    }
    return out;
  }

 private:
  struct Mean {
    std::array<double, 4> sums{};  // Of HoursPerformance's ways.
    std::size_t frames = 0;
  };
  std::span<const performer::HeldExpression> held_;
  std::vector<Mean> means_;
};

class HoursPerformance {
 public:
  /// `sensor`: that to which something happens, among the rig's.
  HoursPerformance(const HoursRequest& request, const sensor::Rig& rig,
                   const std::vector<virt::SkinSite>& sites, const face::Face& face,
                   std::optional<std::uint16_t> sensor, Random random, std::vector<HoursWay> ways)
      : request_(request),
        sites_(sites),
        sensor_(sensor),
        face_sensors_(rig.face_sensors()),
        meter_(face),
        noise_(std::move(random)),
        ways_(std::move(ways)),
        pipeline_(rig),
        frozen_(rig, {.track_heading = false}),
        held_(request.held),
        released_(request.held) {}

  void mark(const std::vector<take::Event>& events) {
    for (const take::Event& event : events)
      for (imu::Pipeline* const pipeline : {&pipeline_, &frozen_})
        pipeline->mark(tracker::step_named(event.kind), event.begin, event.end);
  }
  void add(const sensor::Sample& sample) {
    pipeline_.add(sample);
    frozen_.add(sample);
  }
  void add(const virt::StreamedFrame& frame, const sensor::TimeLines& lines) {
    pipeline_.tick(frame.tick.frame, lines, device_);
    frozen_.tick(frame.tick.frame, lines, frozen_features_);
    lab_.sensors.assign(face_sensors_.size(), {});
    known_ = device_;
    std::vector<Quat> truth;
    for (std::size_t i = 0; i < face_sensors_.size(); ++i) {
      truth.push_back(sites_[face_sensors_[i]].rotation(frame.weights));
      Vec3 rotation = log_rotation(truth[i]);
      for (double& axis : rotation) axis += virt::kLabNoiseRad * noise_.normal();
      put_rotation(exp_rotation(rotation), lab_.sensors[i]);
      put_rotation(truth[i], known_.sensors[i]);
    }
    for (std::size_t way = 0; way < ways_.size(); ++way) ways_[way].step(*features_[way]);
    if (frame.motion_s < 0) return;
    if (frame.motion_s >= piece_begin_s_ + performer::kPieceS) end_piece();
    for (HoursWay& way : ways_) way.errors.add(way.answer.weights, frame.weights);
    add_rotations(truth);
    add_held(frame.motion_s);
    if (frames_++ % kSampledFrames != 0) return;
    truth_.push_back(frame.weights);
    for (HoursWay& way : ways_) way.sampled.push_back(way.answer.weights);
  }
  [[nodiscard]] std::vector<HoursPiece> finish() {
    end_piece();
    return std::move(pieces_);
  }

 private:
  void add_rotations(const std::vector<Quat>& truth) {
    const Vec3 up = device_.head.conjugate() * Vec3::UnitY();
    for (std::size_t i = 0; i < truth.size(); ++i) {
      ++expected_;
      const bool watched = sensor_ == face_sensors_[i];
      if (watched && frozen_features_.sensors[i].has_rotation)
        frozen_sensor_errors_.add(rotation_error(frozen_features_.sensors[i], truth[i]));
      if (!device_.sensors[i].has_rotation) continue;
      const Vec3 error = rotation_error(device_.sensors[i], truth[i]);
      rotation_errors_.add(error);
      vertical_errors_.add(error.dot(up) * up);
      if (watched) sensor_errors_.add(error);
      if (frames_ % kSampledFrames != 0) continue;
      nees_ += error.dot(pipeline_.status(face_sensors_[i]).drift_rad2.inverse() * error) / 3;
      ++judged_;
    }
  }
  void add_held(double motion_s) {
    for (std::size_t h = 0; h < request_.held.size(); ++h) {
      const performer::HeldExpression& held = request_.held[h];
      if (motion_s >= held.begin_s + kSettledS && motion_s <= held.end_s) held_.add(h, ways_);
      const double released_s = motion_s - held.end_s - kReleasedS;
      if (released_s >= 0 && released_s < 1) released_.add(h, ways_);
    }
  }
  void end_piece() {
    if (frames_ == 0) return;
    HoursPiece piece{.begin_s = piece_begin_s_, .frames = frames_};
    const auto each = [&](auto value) {
      return HoursErrors{value(ways_[0]), value(ways_[1]), value(ways_[2]), value(ways_[3])};
    };
    piece.mse = each([&](const HoursWay& way) { return way.errors.mse(); });
    const auto pve = [&](const HoursWay& way) {
      const measure::Stretch stretch{.truth = truth_, .estimate = way.sampled};
      return meter_.measure({&stretch, 1}).pve_mm.mean;
    };
    piece.pve_mm = pve(ways_[0]);
    piece.lab_pve_mm = pve(ways_[1]);
    std::array<double, face::kShapeCount> bias{};
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      bias[k] = ways_[0].errors.bias(k) - ways_[1].errors.bias(k);
    if (pieces_.empty()) first_bias_ = bias;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double grown = std::abs(bias[k]) - std::abs(first_bias_[k]);
      if (k > 0 && grown <= piece.worst_bias) continue;
      piece.worst_shape = k;
      piece.worst_bias = grown;
    }
    piece.rotation_rms_deg = rotation_errors_.rms_deg();
    piece.vertical_rms_deg = vertical_errors_.rms_deg();
    piece.sensor_rms_deg = sensor_errors_.rms_deg();
    piece.frozen_sensor_rms_deg = frozen_sensor_errors_.rms_deg();
    piece.nees = judged_ > 0 ? nees_ / static_cast<double>(judged_) : 0;
    piece.missing = 1 - static_cast<double>(rotation_errors_.count) /
                            static_cast<double>(std::max<std::size_t>(1, expected_));
    const double relative = piece.mse.device / piece.mse.lab;
    piece.ratio = pieces_.empty() ? 1 : relative / (pieces_.front().mse.device / pieces_.front().mse.lab);
    piece.held = held_.take();
    piece.released = released_.take();
    pieces_.push_back(std::move(piece));
    piece_begin_s_ += performer::kPieceS;
    frames_ = expected_ = judged_ = 0;
    nees_ = 0;
    rotation_errors_ = vertical_errors_ = sensor_errors_ = frozen_sensor_errors_ = {};
    truth_.clear();
    for (HoursWay& way : ways_) {
      way.errors = {};
      way.sampled.clear();
    }
  }

  /// An expression counts as held from this long after it began, s.
  static constexpr double kSettledS = 2;
  /// The second that begins so long after an expression's end tells what is left of it, s.
  static constexpr double kReleasedS = 10;
  const HoursRequest& request_;
  const std::vector<virt::SkinSite>& sites_;
  std::optional<std::uint16_t> sensor_;
  std::vector<std::uint16_t> face_sensors_;
  measure::Meter meter_;
  Random noise_;
  std::vector<HoursWay> ways_;  // Device, lab, known, frozen.
  imu::Pipeline pipeline_, frozen_;
  model::FeatureFrame device_, lab_, known_, frozen_features_;
  std::array<const model::FeatureFrame*, 4> features_ = {&device_, &lab_, &known_, &frozen_features_};

  std::vector<HoursPiece> pieces_;
  std::array<double, face::kShapeCount> first_bias_{};
  double piece_begin_s_ = 0;
  std::size_t frames_ = 0, expected_ = 0, judged_ = 0;
  double nees_ = 0;
  RotationErrors rotation_errors_, vertical_errors_, sensor_errors_, frozen_sensor_errors_;
  std::vector<Weights> truth_;
  ShapeMeans held_, released_;
};

/// One performance of the study: a script's or a motion's, in a scenario.
struct HoursJob {
  performer::Block script = performer::Block::mixed;
  const face::Motion* motion = nullptr;  // In place of the script.
  const HoursScenario* scenario = nullptr;
  std::uint64_t seed = 0;

  [[nodiscard]] std::string name() const {
    return motion != nullptr ? motion->name : std::string(performer::block_name(script));
  }
};

/// Names all of the request that its figures depend on.
std::string key_of(const HoursRequest& request, const HoursJob& job) {
  std::string key =
      fmt::format("{}, {}, seed {}, {} minutes", job.name(), job.scenario->name, job.seed, request.minutes);
  for (const performer::HeldExpression& held : request.held)
    key += fmt::format(", held {} at {} from {} to {} s", fmt::join(held.shapes, "+"), held.value,
                       held.begin_s, held.end_s);
  Sha256 hash;
  if (job.motion != nullptr)
    for (const face::MotionFrame& frame : job.motion->frames) {
      for (const double value :
           {frame.time_s, frame.head.w(), frame.head.x(), frame.head.y(), frame.head.z(),
            frame.head_position_m.x(), frame.head_position_m.y(), frame.head_position_m.z()})
        hash.add_value(value);
      hash.add(std::as_bytes(std::span(frame.weights.values)));
      hash.add_value(frame.has_face);
    }
  if (request.face) {
    hash.add(std::as_bytes(std::span(request.face->neutral_m)));
    for (const face::Shape& shape : request.face->shapes) {
      hash.add(std::as_bytes(std::span(shape.vertex)));
      hash.add(std::as_bytes(std::span(shape.delta_m)));
    }
  }
  return key + ", " + hash.hex();
}

performer::LongMotion motion_of(const HoursRequest& request, const HoursJob& job,
                                const performer::Style& style, const Random& root) {
  const bool still = job.scenario->head_still;
  const auto keep_still = [still](face::Motion motion) {
    if (still)
      for (face::MotionFrame& frame : motion.frames) {
        frame.head = Quat::Identity();
        frame.head_position_m = Vec3::Zero();
      }
    motion.has_head = motion.has_head || still;
    return motion;
  };
  const auto begun = [&root](const face::Motion& motion) {
    return performer::with_prologue(motion, performer::PrologueKind::brief, root.fork("prologue"));
  };
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  if (job.motion == nullptr) {
    const auto draw = [keep_still, style, root, script = job.script](std::size_t piece) {
      return keep_still(performer::perform(performer::default_script(script, performer::kPieceS), style,
                                           root.fork("piece", piece)));
    };
    return {begun(draw(0)), {.draw = draw, .duration_s = kEndless}, request.held};
  }
  face::Motion motion = keep_still(*job.motion);
  if (!motion.has_head) motion = performer::with_head_motion(motion, root.fork("head"));
  performer::PrologueMotion repeated = begun(motion);
  const performer::Encore encore = performer::add_encore(repeated);
  return {repeated, encore, kEndless, request.held};
}

/// What a scenario has happen to a sensor.
Result<std::vector<virt::SensorEvent>> events_of(const HoursEvent& event, std::uint16_t sensor,
                                                 const sensor::Rig& rig, const face::Face& face,
                                                 Random random) {
  std::vector<virt::SensorEvent> out;
  for (const double restart_min : event.restarts_min)
    if (restart_min > 0) out.push_back({.sensor = sensor, .begin_s = 60 * restart_min, .restarts = true});
  if (event.begin_min <= 0) return out;
  virt::SensorEvent& one = out.emplace_back();
  one.sensor = sensor;
  one.begin_s = 60 * event.begin_min;
  one.end_s = 60 * event.end_min;
  one.turn_rad = event.turn_deg * kRadPerDeg * random.direction();
  one.silent = event.silent;
  if (event.heading_deg != 0) one.heading_rad = event.heading_deg * kRadPerDeg;
  if (event.shift_mm > 0) {
    MIEN_TRY_ASSIGN(
        const std::vector<virt::SkinSite> elsewhere,
        virt::skin_sites(face, rig, virt::draw_placement(rig, 1e-3 * event.shift_mm, random.fork("again"))));
    one.site = elsewhere[sensor];
  }
  return out;
}

Result<HoursRun> perform_hours(const HoursRequest& request, const sensor::Rig& rig,
                               const model::ModelFile& model, const HoursJob& job, Clock& clock) {
  MIEN_TRY_ASSIGN(virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  if (job.scenario->faults != nullptr) faults = job.scenario->faults(faults);
  const Random root = Random(job.seed).fork("hours");
  virt::VirtualPerson person = virt::draw_person(root);
  if (request.face) person.face = *request.face;
  MIEN_TRY_ASSIGN(
      std::vector<virt::SkinSite> sites,
      virt::skin_sites(person.face, rig,
                       virt::draw_placement(rig, 1e-3 * faults.mount_position_mm, root.fork("placement"))));
  std::optional<std::uint16_t> sensor;
  std::vector<virt::SensorEvent> events;
  if (job.scenario->event.last_min() > 0) {
    Random random = root.fork("event");
    const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
    sensor = face_sensors[random.below(face_sensors.size())];
    MIEN_TRY_ASSIGN(events, events_of(job.scenario->event, *sensor, rig, person.face, random));
  }
  MIEN_TRY_ASSIGN(virt::StreamedSession session,
                  virt::StreamedSession::create(rig, std::move(sites), faults,
                                                motion_of(request, job, person.style, root.fork(job.name())),
                                                root.fork("devices"), std::move(events)));
  std::vector<HoursWay> ways;
  for (int way = 0; way < 4; ++way) {
    MIEN_TRY_ASSIGN(tracker::CausalTracker tracker,
                    tracker::CausalTracker::create(model, rig.face_sensor_names()));
    ways.push_back({.tracker = std::move(tracker)});
  }
  HoursPerformance performing(request, rig, session.sites(), person.face, sensor, root.fork("lab noise"),
                              std::move(ways));
  performing.mark(session.events());
  double reached_s = 0;
  const virt::StreamConsumer consumer{
      .sample = [&](HostTime, const sensor::Sample& sample) { performing.add(sample); },
      .frame =
          [&](const virt::StreamedFrame& frame, const sensor::TimeLines& lines) {
            reached_s = frame.motion_s;
            if (frame.motion_s < 60 * request.minutes) performing.add(frame, lines);
          }};
  for (double counted_s = 0; reached_s < 60 * request.minutes;) {
    MIEN_TRY(session.next(consumer));
    if (clock.stopped) return fail(ErrorCode::cancelled, "stopped", "hours study");
    if (reached_s < counted_s + 60) continue;
    counted_s += 60;
    ++clock.minutes;
  }
  return HoursRun{.script = job.name(),
                  .scenario = std::string(job.scenario->name),
                  .seed = job.seed,
                  .sensor = sensor ? rig.sensors[*sensor].name : "",
                  .event_end_s = 60 * job.scenario->event.last_min(),
                  .pieces = performing.finish()};
}

HoursErrors mean_of(std::span<const HoursRun> runs, const HoursPiece& (*piece)(const HoursRun&)) {
  HoursErrors sum;
  for (const HoursRun& run : runs) {
    const HoursErrors& mse = piece(run).mse;
    sum.device += mse.device;
    sum.lab += mse.lab;
    sum.known += mse.known;
    sum.frozen += mse.frozen;
  }
  const auto count = static_cast<double>(runs.size());
  return {sum.device / count, sum.lab / count, sum.known / count, sum.frozen / count};
}

/// The one that begins ten minutes after what happens to a sensor, within a minute; the last one if none
/// does.
const HoursPiece& piece_after(const HoursRun& run) {
  for (const HoursPiece& piece : run.pieces)
    if (piece.begin_s >= run.event_end_s + performer::kPieceS - 60) return piece;
  return run.pieces.back();
}

HoursSummary summary_of(std::span<const HoursRun> runs) {
  HoursSummary out{.script = runs.front().script, .scenario = runs.front().scenario, .runs = runs.size()};
  out.first_mse = mean_of(runs, [](const HoursRun& run) -> const HoursPiece& { return run.pieces.front(); });
  out.last_mse = mean_of(runs, [](const HoursRun& run) -> const HoursPiece& { return run.pieces.back(); });
  out.within_most = share_within(runs, kRatioOfMost);
  out.within_all = share_within(runs, kRatioOfAll);
  for (std::size_t p = 0; p < runs.front().pieces.size(); ++p) {
    double rotation_deg = 0, nees = 0;
    for (const HoursRun& run : runs) {
      const HoursPiece& piece = run.pieces[p];
      rotation_deg += piece.rotation_rms_deg / static_cast<double>(runs.size());
      nees += piece.nees / static_cast<double>(runs.size());
      if (p == 0) out.first_missing += piece.missing / static_cast<double>(runs.size());
      out.worst_ratio = std::max(out.worst_ratio, piece.ratio);
      out.worst_missing = std::max(out.worst_missing, piece.missing);
      if (piece.worst_bias > out.worst_bias) {
        out.worst_bias = piece.worst_bias;
        out.worst_shape = piece.worst_shape;
      }
    }
    if (p == 0) out.first_rotation_deg = rotation_deg;
    out.worst_rotation_deg = std::max(out.worst_rotation_deg, rotation_deg);
    out.least_nees = p == 0 ? nees : std::min(out.least_nees, nees);
    out.most_nees = std::max(out.most_nees, nees);
  }
  for (const HoursRun& run : runs) {
    const HoursPiece& piece = piece_after(run);
    const auto count = static_cast<double>(runs.size());
    out.sensor_deg += piece.sensor_rms_deg * piece.sensor_rms_deg / count;
    out.frozen_sensor_deg += piece.frozen_sensor_rms_deg * piece.frozen_sensor_rms_deg / count;
  }
  out.sensor_deg = std::sqrt(out.sensor_deg);
  out.frozen_sensor_deg = std::sqrt(out.frozen_sensor_deg);
  return out;
}

}  // namespace

Result<std::vector<HoursRun>> study_hours(const HoursRequest& request, const sensor::Rig& rig,
                                          const model::ModelFile& model, const Progress& progress,
                                          const HoursCache* cache) {
  std::vector<HoursJob> jobs;
  const auto add = [&](HoursJob job) {
    for (const HoursScenario& scenario : request.scenarios)
      for (std::uint64_t seed = request.first_seed; seed < request.first_seed + request.seeds; ++seed) {
        job.scenario = &scenario;
        job.seed = seed;
        jobs.push_back(job);
      }
  };
  for (const performer::Block script : request.scripts) add({.script = script});
  for (const face::Motion& motion : request.motions) add({.motion = &motion});
  if (jobs.empty() || !(request.minutes > 0))
    return fail(ErrorCode::bad_usage, "nobody performs", "hours study",
                "give a script or a motion, a scenario, a seed and minutes");
  MIEN_TRY(tracker::CausalTracker::create(model, rig.face_sensor_names()));
  std::vector<HoursRun> runs(jobs.size());
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    std::optional<HoursRun> known = cache != nullptr ? cache->find(key_of(request, jobs[i])) : std::nullopt;
    if (known)
      runs[i] = std::move(*known);
    else
      missing.push_back(i);
  }
  Clock clock;
  const auto kept = static_cast<double>(jobs.size() - missing.size());
  const Progress watch = [&](double performers, std::string_view) {
    const auto all = static_cast<double>(jobs.size());
    const double done = kept * request.minutes + static_cast<double>(clock.minutes);
    if (!progress(performers < 1 ? std::min(0.99, done / (all * request.minutes)) : 1.0,
                  fmt::format("{:.0f} of {:.0f} performances, {:.0f} of {:.0f} minutes",
                              kept + performers * static_cast<double>(missing.size()), all, done,
                              all * request.minutes)))
      clock.stopped = true;
    return !clock.stopped;
  };
  MIEN_TRY(
      virt::for_each_performer(missing.size(), request.threads, watch, [&](std::size_t i) -> Result<void> {
        const HoursJob& job = jobs[missing[i]];
        MIEN_TRY_ASSIGN(runs[missing[i]], perform_hours(request, rig, model, job, clock));
        return cache != nullptr ? cache->keep(key_of(request, job), runs[missing[i]]) : Result<void>();
      }));
  return runs;
}

std::vector<HoursSummary> summarise(std::span<const HoursRun> runs) {
  std::vector<HoursSummary> out;
  for (const HoursRun& run : runs) {
    const auto same = [&run](const auto& other) {
      return other.script == run.script && other.scenario == run.scenario;
    };
    if (std::ranges::any_of(out, same)) continue;
    std::vector<HoursRun> alike;
    std::ranges::copy_if(runs, std::back_inserter(alike), same);
    out.push_back(summary_of(alike));
  }
  return out;
}

double share_within(std::span<const HoursRun> runs, double limit) {
  const auto within = std::ranges::count_if(runs, [limit](const HoursRun& run) {
    return std::ranges::all_of(run.pieces, [limit](const HoursPiece& piece) { return piece.ratio <= limit; });
  });
  return runs.empty() ? 0 : static_cast<double>(within) / static_cast<double>(runs.size());
}

}  // namespace mien::lab
