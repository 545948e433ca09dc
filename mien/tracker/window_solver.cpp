#include "mien/tracker/window_solver.h"

#include <algorithm>
#include <utility>

#include "mien/model/sampler.h"
#include "mien/tracker/model_input.h"
#include "mien/tracker/provenance.h"

namespace mien::tracker {

WindowSolver::WindowSolver(model::ModelFile file, model::Denoiser denoiser)
    : file_(std::move(file)), denoiser_(std::move(denoiser)) {}

Result<WindowSolver> WindowSolver::create(model::ModelFile file, model::Precision precision) {
  if (!std::ranges::equal(file.shapes, face::kShapeNames))
    return fail(ErrorCode::mismatch, "the model's outputs are not the 53 ICT shapes in their order",
                "model file", "train it with this version of Mien");
  MIEN_TRY_ASSIGN(model::Denoiser denoiser,
                  model::Denoiser::create(file.architecture, file.network, precision));
  return WindowSolver(std::move(file), std::move(denoiser));
}

Result<std::vector<face::OutputFrame>> WindowSolver::solve(std::span<const model::FeatureFrame> features,
                                                           const std::vector<std::string>& sensors,
                                                           const model::SamplerSettings& settings,
                                                           const Progress& progress) const {
  ModelInput input(file_, sensors);
  if (input.empty())
    return fail(ErrorCode::mismatch, "the take's rig has none of the model's sensors", "model file",
                "use a model that was trained for this rig");
  const std::size_t width = file_.features.width();
  std::vector<float> condition(features.size() * width);
  std::vector<std::size_t> present;
  for (std::size_t f = 0; f < features.size(); ++f) {
    input.encode(features[f], std::span(condition).subspan(f * width, width));
    present.push_back(input.present_count());
  }
  MIEN_TRY_ASSIGN(const std::vector<float> weights,
                  model::solve_windows(denoiser_, file_.schedule, condition, settings, progress));
  std::vector<face::OutputFrame> out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    face::OutputFrame& frame = out[f];
    frame.time = features[f].time;
    std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(f * face::kShapeCount), face::kShapeCount,
                frame.weights.values.begin());
    frame.confidence.fill(static_cast<float>(present[f]) / static_cast<float>(input.sensor_count()));
    set_provenance(present[f] > 0, Gaze::unseen, frame);
    if (features[f].has_head) {
      frame.head = features[f].head;
      frame.head_confidence = 1;
      frame.head_provenance = face::Provenance::measured;
    }
  }
  return out;
}

}  // namespace mien::tracker
