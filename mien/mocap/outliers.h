#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace mien::mocap {

/// How many standard deviations from its mean a marker may be, as the published study has it.
inline constexpr double kOutlierSigmas = 4;

/// The rows that may be learnt from. Shape of `rows`: samples x numbers.
struct Kept {
  std::vector<std::size_t> rows;  ///< Ascending.
  std::size_t rejected = 0;       ///< Not finite, or out of line.
};

/// Rejects every sample in which any number lies more than `sigmas` standard deviations (of that number, over
/// all finite samples) from its mean. Once, not repeated: what is drawn in later is judged as it was.
[[nodiscard]] Kept reject_outliers(const Eigen::MatrixXd& rows, double sigmas = kOutlierSigmas);

}  // namespace mien::mocap
