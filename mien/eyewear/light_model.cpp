#include "mien/eyewear/light_model.h"

#include <fmt/format.h>

#include <algorithm>
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

Result<MarkedShapes> mark_builtin(const builtin_face::MarkerSet& markers) {
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), markers));
  return MarkedShapes{placed.at({}), placed.shapes_m()};
}

Result<MarkedFace> MarkedFace::create(std::string name, const MarkedShapes& shapes) {
  MIEN_TRY_ASSIGN(face::WeightSolver solver,
                  face::WeightSolver::create(shapes.neutral_m, shapes.shapes_m, face::natural_constraints(),
                                             {.rest = kRest}));
  return MarkedFace{std::move(name), shapes.neutral_m, std::move(solver)};
}

Result<MarkedFace> MarkedFace::of(const MarkerNetworkFile& file, const builtin_face::MarkerSet& markers) {
  if (!std::ranges::equal(file.markers, markers.markers, {}, {}, &builtin_face::Marker::name))
    return fail(ErrorCode::mismatch,
                fmt::format("the model answers with other markers than {}", markers.name), "model",
                "train one with this program's markers");
  if (file.face) return create(markers.name, *file.face);
  MIEN_TRY_ASSIGN(const MarkedShapes shapes, mark_builtin(markers));
  return create(markers.name, shapes);
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
