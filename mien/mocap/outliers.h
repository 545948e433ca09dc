#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace mien::mocap {

/// Outlier threshold in standard deviations (Asano et al. 2017).
inline constexpr double kOutlierSigmas = 4;

/// Result of outlier rejection.
struct Kept {
  std::vector<std::size_t> rows;  ///< Accepted rows, ascending.
  std::size_t rejected = 0;       ///< Number of rows not finite or beyond the threshold.
};

/// Rejects every sample (row) of `rows`, samples x values, in which any value lies more than `sigmas`
/// standard deviations, of that value over all finite samples, from its mean. A single pass.
[[nodiscard]] Kept reject_outliers(const Eigen::MatrixXd& rows, double sigmas = kOutlierSigmas);

}  // namespace mien::mocap
