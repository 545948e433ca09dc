#include "mien/solve/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "mien/face/face.h"
#include "mien/face/frame_hash.h"
#include "mien/shaping/shaper.h"
#include "mien/tracker/model_input.h"

namespace mien::solve {
namespace {

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
  out.ridge = tracker::solve_ridge(file, features, take.rig().face_sensor_names(),
                                   take.header().devices == "lab" ? "lab" : "device");
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

bool recorded_live(const take::Take& take) {
  return take.header().devices == "live";
}

Result<Solution> solve_take(const take::Take& take, const tracker::WindowSolver& solver,
                            const model::SamplerSettings& settings, const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, take_features(take));
  Solution out;
  MIEN_TRY_ASSIGN(out.frames, solver.solve(features, take.rig().face_sensor_names(), settings, progress));
  complete(take, solver.file(), features, out);
  return out;
}

Result<Solution> solve_take(const take::Take& take, tracker::CausalTracker& tracker,
                            const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, take_features(take));
  return solve_take(take, features, tracker, progress);
}

Result<Solution> solve_take(const take::Take& take, std::span<const model::FeatureFrame> features,
                            tracker::CausalTracker& tracker, const Progress& progress) {
  constexpr std::size_t kShownEvery = 600;
  Solution out;
  out.frames.resize(features.size());
  tracker.reset();
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (f % kShownEvery == 0 &&
        !progress(static_cast<double>(f) / static_cast<double>(features.size()), "frame by frame"))
      return fail(ErrorCode::cancelled, "stopped while solving");
    tracker.step(features[f], out.frames[f]);
  }
  tracker.reset();
  progress(1, "frame by frame");
  complete(take, tracker.file(), features, out);
  return out;
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
