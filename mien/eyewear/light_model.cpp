#include "mien/eyewear/light_model.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "mien/builtin_face/builtin_face.h"

namespace mien::eyewear {
namespace {

/// face::WeightSolverSettings::rest for estimated markers, which are millimetres off: of 0.5 to 1000 the
/// least squared error of the weights (docs/experiments/eyewear.md).
constexpr double kRest = 100;

std::optional<model::ConfidenceTable> table_of(const MarkerRegressor& regressor) {
  const model::ConfidenceTable* table = regressor.confidence();
  return table != nullptr ? std::optional(*table) : std::nullopt;
}

}  // namespace

Result<MarkedFace> MarkedFace::create(const builtin_face::MarkerSet& markers) {
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), markers));
  Eigen::VectorXd neutral_m = placed.at({});
  MIEN_TRY_ASSIGN(
      face::WeightSolver solver,
      face::WeightSolver::create(neutral_m, placed.shapes_m(), face::natural_rules(), {.rest = kRest}));
  return MarkedFace{markers.name, std::move(neutral_m), std::move(solver)};
}

Result<LightModel> LightModel::create(MarkedFace face, std::unique_ptr<MarkerRegressor> regressor) {
  if (regressor->marker_count() != face.solver.point_count())
    return fail(ErrorCode::mismatch,
                fmt::format("the model has {} markers, and {} has {}", regressor->marker_count(), face.name,
                            face.solver.point_count()),
                "model", "use the markers that the model was made with");
  return LightModel(std::move(face), std::move(regressor));
}

LightModel::LightModel(MarkedFace face, std::unique_ptr<MarkerRegressor> regressor)
    : face_(std::move(face)),
      regressor_(std::move(regressor)),
      confidence_(table_of(*regressor_)),
      markers_m_(face_.neutral_m) {}

void LightModel::step(const LightFrame& light, double since_s, face::OutputFrame& out) {
  regressor_->step(light, markers_m_);
  markers_m_ += face_.neutral_m;
  face_.solver.solve(markers_m_, {}, since_s, out.weights);
  tracker::Coverage coverage;
  coverage.fill(regressor_->coverage());
  explained_ = confidence_.write(coverage, out);
}

}  // namespace mien::eyewear
