#include "mien/tracker/window_solver.h"

#include <algorithm>
#include <utility>

#include "mien/model/sampler.h"
#include "mien/tracker/frame_writer.h"
#include "mien/tracker/model_input.h"

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
  for (std::size_t f = 0; f < features.size(); ++f)
    input.encode(features[f], std::span(condition).subspan(f * width, width));
  MIEN_TRY_ASSIGN(const std::vector<float> weights,
                  model::solve_windows(denoiser_, file_.schedule, condition, settings, progress));
  const FrameWriter writer(file_);
  std::vector<face::OutputFrame> out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(f * face::kShapeCount), face::kShapeCount,
                out[f].weights.values.begin());
    // Who is present stands in the input: encoded again, which costs little beside the windows.
    input.encode(features[f], std::span(condition).first(width));
    writer.write(features[f], input, out[f]);
  }
  return out;
}

}  // namespace mien::tracker
