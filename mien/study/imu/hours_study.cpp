#include "mien/study/imu/hours_study.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "mien/core/units.h"
#include "mien/imu/pipeline.h"
#include "mien/measure/metrics.h"
#include "mien/study/imu/hours_session.h"
#include "mien/study/performance.h"
#include "mien/study/performers.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/virtual/imu/imu_session.h"

namespace mien::study {
namespace {

/// Vertex errors are measured on every such frame, and the filter's consistency too.
constexpr std::size_t kSampledFrames = 20;

using Weights = face::BlendshapeWeights;

void put_rotation(const Quat& rotation, model::SensorFeature& feature) {
  const Quat unit = canonical(rotation);
  feature.rotation = {static_cast<float>(unit.w()), static_cast<float>(unit.x()),
                      static_cast<float>(unit.y()), static_cast<float>(unit.z())};
  feature.has_rotation = true;
}

/// One way to the weights, and what it errs in the present piece.
struct HoursWay {
  tracker::CausalTracker tracker;
  face::OutputFrame answer;
  double squares = 0;
  std::array<double, face::kShapeCount> errors{};
  std::vector<Weights> sampled;
  std::vector<double> held;

  void step(const model::FeatureFrame& features) { tracker.step(features, answer); }
  void add(const Weights& truth) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double error = std::clamp(answer.weights[k], 0.0F, 1.0F) - std::clamp(truth[k], 0.0F, 1.0F);
      squares += error * error / face::kShapeCount;
      errors[k] += error;
    }
  }
};

/// Minutes that all performers have performed, and whether to stop.
struct Clock {
  std::atomic<std::size_t> minutes = 0;
  std::atomic<bool> stopped = false;
};

class HoursPerformance {
 public:
  HoursPerformance(const HoursRequest& request, const sensor::Rig& rig,
                   const std::vector<virt::SkinSite>& sites, const face::Face& face, Random random,
                   std::vector<HoursWay> ways)
      : request_(request),
        sites_(sites),
        face_sensors_(rig.face_sensors()),
        meter_(face),
        noise_(std::move(random)),
        ways_(std::move(ways)),
        pipeline_(rig),
        frozen_(rig, {.track_heading = false}) {}

  void mark(const std::vector<take::Event>& events) {
    for (const take::Event& event : events)
      if (const auto phase = imu::phase_of(event.kind)) {
        pipeline_.mark(*phase, event.begin, event.end);
        frozen_.mark(*phase, event.begin, event.end);
      }
  }
  void add(const sensor::Sample& sample) {
    pipeline_.add(sample);
    frozen_.add(sample);
  }
  void add(const HoursFrame& frame, const sensor::TimeLines& lines) {
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
    if (frame.motion_s >= piece_begin_s_ + kPieceS) end_piece();
    for (HoursWay& way : ways_) way.add(frame.weights);
    add_rotations(truth);
    add_held(frame);
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
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const model::SensorFeature& feature = device_.sensors[i];
      ++expected_;
      if (!feature.has_rotation) continue;
      ++given_;
      const auto& [w, x, y, z] = feature.rotation;
      const Vec3 error = log_rotation(Quat(w, x, y, z) * truth[i].conjugate());
      squares_rad2_ += error.squaredNorm();
      if (frames_ % kSampledFrames != 0) continue;
      nees_ += error.dot(pipeline_.status(face_sensors_[i]).drift_rad2.inverse() * error) / 3;
      ++judged_;
    }
  }
  void add_held(const HoursFrame& frame) {
    for (HoursWay& way : ways_) way.held.resize(request_.held.size());
    held_frames_.resize(request_.held.size());
    for (std::size_t h = 0; h < request_.held.size(); ++h) {
      const HeldExpression& held = request_.held[h];
      if (frame.motion_s < held.begin_s + kSettledS || frame.motion_s > held.end_s) continue;
      ++held_frames_[h];
      for (HoursWay& way : ways_)
        for (const std::size_t k : held.shapes)
          way.held[h] += way.answer.weights[k] / static_cast<double>(held.shapes.size());
    }
  }
  void end_piece() {
    if (frames_ == 0) return;
    const auto frames = static_cast<double>(frames_);
    HoursPiece piece{.begin_s = piece_begin_s_, .frames = frames_};
    const auto each = [&](auto value) {
      return HoursErrors{value(ways_[0]), value(ways_[1]), value(ways_[2]), value(ways_[3])};
    };
    piece.mse = each([&](const HoursWay& way) { return way.squares / frames; });
    const auto pve = [&](const HoursWay& way) {
      const measure::Stretch stretch{.truth = truth_, .estimate = way.sampled};
      return meter_.measure({&stretch, 1}).pve_mm.mean;
    };
    piece.pve_mm = pve(ways_[0]);
    piece.lab_pve_mm = pve(ways_[1]);
    std::array<double, face::kShapeCount> bias{};
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      bias[k] = (ways_[0].errors[k] - ways_[1].errors[k]) / frames;
    if (pieces_.empty()) first_bias_ = bias;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double grown = std::abs(bias[k]) - std::abs(first_bias_[k]);
      if (k > 0 && grown <= piece.worst_bias) continue;
      piece.worst_shape = k;
      piece.worst_bias = grown;
    }
    piece.rotation_rms_deg =
        given_ > 0 ? kDegPerRad * std::sqrt(squares_rad2_ / static_cast<double>(given_)) : 0;
    piece.nees = judged_ > 0 ? nees_ / static_cast<double>(judged_) : 0;
    piece.missing =
        1 - static_cast<double>(given_) / static_cast<double>(std::max<std::size_t>(1, expected_));
    const double relative = piece.mse.device / piece.mse.lab;
    piece.ratio = pieces_.empty() ? 1 : relative / (pieces_.front().mse.device / pieces_.front().mse.lab);
    for (std::size_t h = 0; h < held_frames_.size(); ++h)
      if (held_frames_[h] > 0)
        piece.held.push_back(
            each([&](const HoursWay& way) { return way.held[h] / static_cast<double>(held_frames_[h]); }));
    pieces_.push_back(std::move(piece));
    piece_begin_s_ += kPieceS;
    frames_ = given_ = expected_ = judged_ = 0;
    squares_rad2_ = nees_ = 0;
    truth_.clear();
    std::ranges::fill(held_frames_, 0);
    for (HoursWay& way : ways_) {
      way.squares = 0;
      way.errors.fill(0);
      way.sampled.clear();
      std::ranges::fill(way.held, 0.0);
    }
  }

  /// An expression counts as held from this long after it began, s.
  static constexpr double kSettledS = 2;
  const HoursRequest& request_;
  const std::vector<virt::SkinSite>& sites_;
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
  std::size_t frames_ = 0, given_ = 0, expected_ = 0, judged_ = 0;
  double squares_rad2_ = 0, nees_ = 0;
  std::vector<Weights> truth_;
  std::vector<std::size_t> held_frames_;
};

Result<HoursRun> perform_hours(const HoursRequest& request, const sensor::Rig& rig,
                               const model::ModelFile& model, performer::Block script, std::uint64_t seed,
                               Clock& clock) {
  virt::DeviceFaults faults;
  faults.mount_rotation_deg = 180;
  if (request.faults) {
    MIEN_TRY_ASSIGN(faults, virt::parse_faults(rig.faults_toml, rig.name));
  }
  const Random root = Random(seed).fork("hours");
  const VirtualPerson person = draw_person(root);
  MIEN_TRY_ASSIGN(
      const std::vector<virt::SkinSite> sites,
      virt::skin_sites(person.face, rig,
                       virt::draw_placement(rig, 1e-3 * faults.mount_position_mm, root.fork("placement"))));
  HoursMotion motion(script, person.style, root.fork(performer::block_name(script)), request.held);
  MIEN_TRY_ASSIGN(HoursSession session,
                  HoursSession::create(rig, sites, faults, std::move(motion), root.fork("devices")));
  std::vector<HoursWay> ways;
  for (int way = 0; way < 4; ++way) {
    MIEN_TRY_ASSIGN(tracker::CausalTracker tracker,
                    tracker::CausalTracker::create(model, rig.face_sensor_names()));
    ways.push_back({.tracker = std::move(tracker)});
  }
  HoursPerformance performing(request, rig, sites, person.face, root.fork("lab noise"), std::move(ways));
  performing.mark(session.events());
  double reached_s = 0;
  const HoursConsumer consumer{
      .sample = [&](HostTime, const sensor::Sample& sample) { performing.add(sample); },
      .frame =
          [&](const HoursFrame& frame, const sensor::TimeLines& lines) {
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
  return HoursRun{std::string(performer::block_name(script)), seed, performing.finish()};
}

/// Names all of the request that one run's figures depend on.
std::string run_key(const HoursRequest& request, performer::Block script, std::uint64_t seed) {
  std::string key = fmt::format("script {}, seed {}, minutes {}, faults {}", performer::block_name(script),
                                seed, request.minutes, request.faults);
  for (const HeldExpression& held : request.held)
    key += fmt::format(", held {} at {} from {} to {} s", fmt::join(held.shapes, "+"), held.value,
                       held.begin_s, held.end_s);
  return key;
}

}  // namespace

Result<std::vector<HoursRun>> study_hours(const HoursRequest& request, const sensor::Rig& rig,
                                          const model::ModelFile& model, const Progress& progress,
                                          const HoursCache* cache) {
  if (request.scripts.empty() || request.seeds == 0 || !(request.minutes > 0))
    return fail(ErrorCode::bad_usage, "nobody performs", "hours study", "give a script, a seed and minutes");
  MIEN_TRY(tracker::CausalTracker::create(model, rig.face_sensor_names()));
  struct Job {
    performer::Block script;
    std::uint64_t seed;
    std::string key;
  };
  std::vector<Job> jobs;
  for (const performer::Block script : request.scripts)
    for (std::uint64_t seed = request.first_seed; seed < request.first_seed + request.seeds; ++seed)
      jobs.push_back({script, seed, run_key(request, script, seed)});
  std::vector<HoursRun> runs(jobs.size());
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    std::optional<HoursRun> known = cache != nullptr ? cache->find(jobs[i].key) : std::nullopt;
    if (known)
      runs[i] = std::move(*known);
    else
      missing.push_back(i);
  }
  Clock clock;
  const double kept = static_cast<double>(jobs.size() - missing.size());
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
  MIEN_TRY(for_each_performer(missing.size(), request.threads, watch, [&](std::size_t i) -> Result<void> {
    const Job& job = jobs[missing[i]];
    MIEN_TRY_ASSIGN(runs[missing[i]], perform_hours(request, rig, model, job.script, job.seed, clock));
    return cache != nullptr ? cache->keep(job.key, runs[missing[i]]) : Result<void>();
  }));
  return runs;
}

}  // namespace mien::study
