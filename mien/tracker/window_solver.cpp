#include "mien/tracker/window_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mien/model/sampler.h"

namespace mien::tracker {
namespace {

/// For each of the model's sensors its place in the features, or -1.
std::vector<std::ptrdiff_t> match_sensors(const std::vector<std::string>& wanted,
                                          const std::vector<std::string>& there) {
  std::vector<std::ptrdiff_t> places;
  for (const std::string& name : wanted) {
    const auto found = std::ranges::find(there, name);
    places.push_back(found == there.end() ? -1 : found - there.begin());
  }
  return places;
}

}  // namespace

WindowSolver::WindowSolver(model::ModelFile file, model::Denoiser denoiser)
    : file_(std::move(file)), denoiser_(std::move(denoiser)) {}

Result<WindowSolver> WindowSolver::create(model::ModelFile file) {
  if (!std::ranges::equal(file.shapes, face::kShapeNames))
    return fail(ErrorCode::mismatch, "the model's outputs are not the 53 ICT shapes in their order",
                "model file", "train it with this version of Mien");
  MIEN_TRY_ASSIGN(model::Denoiser denoiser, model::Denoiser::create(file.architecture, file.network));
  return WindowSolver(std::move(file), std::move(denoiser));
}

std::vector<float> WindowSolver::condition(std::span<const model::FeatureFrame> features,
                                           const std::vector<std::string>& sensors) const {
  const std::vector<std::ptrdiff_t> places = match_sensors(file_.features.sensors, sensors);
  const std::size_t width = file_.features.width();
  std::vector<float> out(features.size() * width);
  model::FeatureFrame frame;
  frame.sensors.resize(places.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    for (std::size_t s = 0; s < places.size(); ++s)
      frame.sensors[s] =
          places[s] < 0 ? model::SensorFeature{} : features[f].sensors[static_cast<std::size_t>(places[s])];
    model::encode_features(file_.features, file_.normalisation, frame,
                           std::span(out).subspan(f * width, width));
  }
  return out;
}

Result<std::vector<face::OutputFrame>> WindowSolver::solve(std::span<const model::FeatureFrame> features,
                                                           const std::vector<std::string>& sensors,
                                                           const model::SamplerSettings& settings,
                                                           const Progress& progress) const {
  const std::vector<std::ptrdiff_t> places = match_sensors(file_.features.sensors, sensors);
  if (std::ranges::all_of(places, [](std::ptrdiff_t place) { return place < 0; }))
    return fail(ErrorCode::mismatch, "the take's rig has none of the model's sensors", "model file",
                "use a model that was trained for this rig");
  MIEN_TRY_ASSIGN(
      const std::vector<float> weights,
      model::solve_windows(denoiser_, file_.schedule, condition(features, sensors), settings, progress));
  std::vector<face::OutputFrame> out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    std::size_t there = 0;
    for (const std::ptrdiff_t place : places)
      if (place >= 0 && features[f].sensors[static_cast<std::size_t>(place)].has_rotation) ++there;
    face::OutputFrame& frame = out[f];
    frame.time = features[f].time;
    std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(f * face::kShapeCount), face::kShapeCount,
                frame.weights.values.begin());
    frame.confidence.fill(static_cast<float>(there) / static_cast<float>(places.size()));
    frame.provenance.fill(there > 0 ? face::Provenance::measured : face::Provenance::predicted);
    if (features[f].has_head) {
      frame.head = features[f].head;
      frame.head_confidence = 1;
      frame.head_provenance = face::Provenance::measured;
    }
  }
  return out;
}

std::vector<face::BlendshapeWeights> WindowSolver::ridge(std::span<const model::FeatureFrame> features,
                                                         const std::vector<std::string>& sensors,
                                                         std::string_view profile) const {
  const model::RidgeBaseline* baseline = file_.ridge_for(profile);
  if (baseline == nullptr) return {};
  const std::vector<float> encoded = condition(features, sensors);
  const std::size_t width = file_.features.width();
  std::vector<face::BlendshapeWeights> out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f)
    baseline->predict(std::span(encoded).subspan(f * width, width), out[f].values);
  return out;
}

}  // namespace mien::tracker
