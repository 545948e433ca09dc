#include "mien/eyewear/marker_model.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

namespace mien::eyewear {

Result<MarkerModel> MarkerModel::fit(const Eigen::MatrixXd& sensors, const Eigen::MatrixXd& markers,
                                     const MarkerModelSettings& settings) {
  if (sensors.rows() != markers.rows())
    return fail(ErrorCode::mismatch, "sensors and markers are not of the same samples", "marker model");
  if (sensors.rows() < sensors.cols() + 2 || sensors.cols() == 0 || markers.cols() == 0)
    return fail(ErrorCode::bad_usage, "there are too few samples to fit a model to", "marker model",
                "record longer");
  if (settings.components < 1 || !(settings.share > 0) || settings.share > 1)
    return fail(ErrorCode::bad_usage, "a model needs at least one component and a share of 0 to 1",
                "marker model");
  if (!sensors.allFinite() || !markers.allFinite())
    return fail(ErrorCode::out_of_range, "a sample is not finite", "marker model", "reject outliers first");

  const auto samples = static_cast<double>(markers.rows());
  MarkerModel model;
  model.mean_ = markers.colwise().mean().transpose();
  const Eigen::MatrixXd centred = markers.rowwise() - model.mean_.transpose();
  // Ascending, as Eigen gives them.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(centred.transpose() * centred / samples);
  const Eigen::VectorXd variance = solver.eigenvalues().cwiseMax(0).reverse();
  const double all = std::max(variance.sum(), 1e-300);
  const Eigen::Index most = std::min<Eigen::Index>(settings.components, markers.cols());
  Eigen::Index components = 0;
  double held = 0;
  while (components < most && (components == 0 || settings.share >= 1 || held < settings.share * all))
    held += variance[components++];
  model.share_ = held / all;
  model.basis_ = solver.eigenvectors().rowwise().reverse().leftCols(components);

  // Centred, so that the constant needs no column.
  const Eigen::RowVectorXd sensor_mean = sensors.colwise().mean();
  const Eigen::MatrixXd scores = centred * model.basis_;
  const Eigen::MatrixXd slopes =
      (sensors.rowwise() - sensor_mean).completeOrthogonalDecomposition().solve(scores);
  model.weights_ = slopes.transpose();
  model.constant_ = -model.weights_ * sensor_mean.transpose();
  return model;
}

Eigen::VectorXd MarkerModel::markers(const Eigen::VectorXd& sensors) const {
  return mean_ + basis_ * (constant_ + weights_ * sensors);
}

}  // namespace mien::eyewear
