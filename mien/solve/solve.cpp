#include "mien/solve/solve.h"

#include <algorithm>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "mien/face/face.h"
#include "mien/face/frame_hash.h"
#include "mien/session/replay.h"
#include "mien/session/session.h"
#include "mien/shaping/shaper.h"
#include "mien/solve/trace_features.h"
#include "mien/tracker/model_input.h"

namespace mien::solve {
namespace {

/// Frames between two calls of the progress.
constexpr std::size_t kShownEvery = 600;

/// The profile whose ridge baseline a take is compared with.
std::string_view ridge_profile(const take::Take& take) {
  return take.header().devices == "lab" ? "lab" : "device";
}

/// How many sensors can stand behind a frame: of IMUs those of the face.
std::size_t tracked_sensors(const sensor::Rig& rig) {
  return static_cast<std::size_t>(std::ranges::count_if(rig.sensors, [](const sensor::Mount& mount) {
    return !mount.is_truth() && (mount.kind != "imu" || mount.role == "face");
  }));
}

/// A solution that grows frame by frame while its take is replayed.
class Collected {
 public:
  Collected(const take::Take& take, const session::Session& session, const modalities::LiveModel& model,
            std::size_t ticks, const Progress& progress)
      : session_(session), sensors_(tracked_sensors(take.rig())), ticks_(ticks), progress_(progress) {
    if (model.imu)
      ridge_ = tracker::RidgeSolver::create(*model.imu, traced_sensor_names(take.rig()), ridge_profile(take));
    out_.frames.reserve(ticks);
    out_.sensors_present.reserve(ticks);
  }
  /// False when it is to stop.
  bool add(const face::OutputFrame& frame) {
    out_.frames.push_back(frame);
    out_.sensors_present.push_back(session_.sensors_present());
    const model::FeatureFrame* const features = session_.features();
    if (ridge_ && features != nullptr) out_.ridge.push_back(ridge_->solve(*features));
    const auto neutral =
        static_cast<std::size_t>(std::ranges::count(frame.provenance, face::Provenance::neutral));
    if (neutral == 0) whole_.add(session_.sensors_present(), sensors_);
    if (neutral < frame.provenance.size() && session_.sensors_present() > 0)
      part_.add(session_.sensors_present(), sensors_);
    const std::size_t done = out_.frames.size();
    return done % kShownEvery != 0 ||
           progress_(static_cast<double>(done) / static_cast<double>(ticks_), "frame by frame");
  }
  Solution finish(bool uncalibrated) {
    progress_(1, "frame by frame");
    out_.observed = whole_.all > 0 ? whole_.share() : part_.share();
    out_.uncalibrated = uncalibrated;
    out_.hash = hash_frames(out_.frames);
    return std::move(out_);
  }

 private:
  struct Tally {
    std::size_t present = 0, all = 0;
    void add(std::size_t sensors_present, std::size_t sensors) {
      present += sensors_present;
      all += sensors;
    }
    [[nodiscard]] double share() const {
      return all > 0 ? static_cast<double>(present) / static_cast<double>(all) : 0;
    }
  };
  const session::Session& session_;
  std::size_t sensors_;
  Solution out_;
  std::optional<tracker::RidgeSolver> ridge_;
  std::size_t ticks_;
  const Progress& progress_;
  Tally whole_;  // Of frames without a neutral shape, ...
  Tally part_;   // ... and of those of which a sensor tells some shape.
};

/// Adds to the frames what stands beside them.
void complete(const take::Take& take, const model::ModelFile& file,
              std::span<const model::FeatureFrame> features, Solution& out) {
  std::size_t observed = 0, all = 0;
  out.sensors_present.clear();
  for (const model::FeatureFrame& frame : features) {
    const auto there =
        static_cast<std::size_t>(std::ranges::count_if(frame.sensors, &model::SensorFeature::has_rotation));
    out.sensors_present.push_back(there);
    observed += there;
    if (observed > 0) all += frame.sensors.size();
  }
  out.observed = all > 0 ? static_cast<double>(observed) / static_cast<double>(all) : 0;
  out.uncalibrated = observed == 0;
  out.ridge = tracker::solve_ridge(file, features, take.rig().face_sensor_names(), ridge_profile(take));
  out.hash = hash_frames(out.frames);
}

}  // namespace

std::string hash_frames(std::span<const face::OutputFrame> frames) {
  face::FrameHash hash;
  for (const face::OutputFrame& frame : frames) hash.add(frame);
  return hash.hex();
}

model::SamplerSettings sampler_of(const model::ModelFile& file, std::size_t steps) {
  model::SamplerSettings settings = file.sampler;
  if (steps == 0) return settings;
  settings.steps = steps;
  settings.kind = steps == file.schedule.levels ? model::SamplerKind::ddpm : model::SamplerKind::ddim;
  return settings;
}

void shape(const shaping::ShaperSettings& settings, Solution& solution) {
  shaping::Shaper shaper(settings);
  for (std::size_t i = 0; i < solution.frames.size(); ++i)
    shaper.apply(solution.frames[i], solution.sensors_present[i]);
  solution.hash = hash_frames(solution.frames);
}

Result<Solution> solve_take(const take::Take& take, const tracker::WindowSolver& solver,
                            const model::SamplerSettings& settings, const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, take_features(take));
  Solution out;
  MIEN_TRY_ASSIGN(out.frames, solver.solve(features, take.rig().face_sensor_names(), settings, progress));
  complete(take, solver.file(), features, out);
  return out;
}

Result<Solution> replay_take(const take::Take& take, const modalities::LiveModel& model,
                             const Progress& progress, const shaping::ShaperSettings& settings) {
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  MIEN_TRY_ASSIGN(const std::unique_ptr<session::Session> session,
                  modalities::make_session(take.rig(), model, settings));
  Collected out(take, *session, model, ticks.size(), progress);
  MIEN_TRY(session::replay(
      take, *session, [&](const take::Tick&, const face::OutputFrame& frame) { return out.add(frame); }));
  session::Report report;
  session->report(ticks.empty() ? HostTime() : ticks.back().fired, report);
  return out.finish(report.calibration.state == "watching" ||
                    (report.calibration.state == "failed" && report.calibration.in_force == 0));
}

Result<std::vector<take::TruthFrame>> own_truth(const take::Take& take) {
  MIEN_TRY_ASSIGN(std::vector<take::TruthFrame> truth, take.truth());
  if (truth.empty())
    return fail(ErrorCode::not_found, "the take has no truth to measure against", take.path().string(),
                "evaluate a take made by mien perform --take, or import a truth track");
  return truth;
}

measure::TakeEstimates with_truth(std::string take, const Solution& solution,
                                  std::span<const take::TruthFrame> truth) {
  measure::TakeEstimates out;
  out.take = std::move(take);
  // Truth stands on the ticks: pair them by time, and leave out ticks that it does not reach (a take cut
  // off).
  std::map<DeviceTime, const take::TruthFrame*> by_time;
  for (const take::TruthFrame& t : truth) by_time.emplace(t.time, &t);
  for (std::size_t i = 0; i < solution.frames.size(); ++i) {
    const auto found = by_time.find(solution.frames[i].time);
    take::TruthFrame frame;
    frame.time = solution.frames[i].time;
    frame.evaluated = false;
    out.truth.push_back(found == by_time.end() ? frame : *found->second);
    out.model.push_back(solution.frames[i].weights);
    out.provenance.push_back(solution.frames[i].provenance);
    const face::OutputFrame& answer = solution.frames[i];
    out.gaze_rad.push_back(answer.eyes_provenance == face::Provenance::neutral
                               ? face::eyes_rad(answer.weights)
                               : answer.eyes_rad);
    out.region_confidence.push_back(answer.region_confidence);
  }
  out.ridge = solution.ridge;
  return out;
}

}  // namespace mien::solve
