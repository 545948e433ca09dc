#include "mien/mocap/outliers.h"

namespace mien::mocap {

Kept reject_outliers(const Eigen::MatrixXd& rows, double sigmas) {
  Kept kept;
  std::vector<Eigen::Index> finite;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(rows.cols());
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (rows.row(i).allFinite()) {
      finite.push_back(i);
      mean += rows.row(i);
    }
  if (!finite.empty()) mean /= static_cast<double>(finite.size());
  Eigen::RowVectorXd variance = Eigen::RowVectorXd::Zero(rows.cols());
  for (const Eigen::Index i : finite) variance += (rows.row(i) - mean).cwiseAbs2();
  if (!finite.empty()) variance /= static_cast<double>(finite.size());
  for (const Eigen::Index i : finite)
    if (((rows.row(i) - mean).array().square() <= sigmas * sigmas * variance.array()).all())
      kept.rows.push_back(static_cast<std::size_t>(i));
  kept.rejected = static_cast<std::size_t>(rows.rows()) - kept.rows.size();
  return kept;
}

}  // namespace mien::mocap
