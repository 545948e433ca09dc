#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/eyewear/marker_network.h"
#include "mien/eyewear/marker_regressor.h"
#include "mien/face/output_frame.h"
#include "mien/face/weight_solver.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::eyewear {

/// A set's markers on the built-in face of this program. Errors: the face's. Cost: makes that face (half a
/// second).
[[nodiscard]] Result<MarkedShapes> mark_builtin(const builtin_face::MarkerSet& markers);

/// A face as a set of markers tells it. Copied for each wearer.
struct MarkedFace {
  /// `name` as below. Errors: the solver's.
  [[nodiscard]] static Result<MarkedFace> create(std::string name, const MarkedShapes& shapes);
  /// The face that the model was trained for; of an older file without it, this program's built-in one.
  /// Errors: mismatch (the model has other markers than the set), those of mark_builtin.
  [[nodiscard]] static Result<MarkedFace> of(const MarkerNetworkFile& file,
                                             const builtin_face::MarkerSet& markers);

  std::string name;           ///< The set's, for errors.
  Eigen::VectorXd neutral_m;  ///< Its markers at neutral: x, y, z of the first, then of the next; frame H.
  face::WeightSolver solver;
};

/// From features of light to weights, frame by frame: markers by a regressor, weights by face::WeightSolver
/// on its model's face, provenance and confidence by the regressor's table. One wearer, one thread.
class LightModel {
 public:
  /// Errors: mismatch (the regressor has another number of markers).
  [[nodiscard]] static Result<LightModel> create(MarkedFace face, std::unique_ptr<MarkerRegressor> regressor);

  /// The next frame: weights, provenance and confidence of `out`, whose other fields stay. `since_s`: since
  /// the frame before, s. No allocation.
  void step(const LightFrame& light, double since_s, face::OutputFrame& out);
  /// Forgets the regressor's memory.
  void reset() { regressor_->reset(); }

  /// Of the last frame: what the sensors explain (zeros without a table), and which share of them was there.
  [[nodiscard]] const tracker::Explained& explained() const { return explained_; }
  [[nodiscard]] float coverage() const { return regressor_->coverage(); }

 private:
  LightModel(MarkedFace face, std::unique_ptr<MarkerRegressor> regressor);

  MarkedFace face_;
  std::unique_ptr<MarkerRegressor> regressor_;
  tracker::ShapeConfidence confidence_;
  Eigen::VectorXd markers_m_;
  tracker::Explained explained_{};
};

}  // namespace mien::eyewear
