#include "mien/imu/skin_turns.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numbers>

namespace mien::imu {
namespace {

using Eigen::Index;

constexpr double kRadPerDeg = std::numbers::pi / 180;
/// What a component of a rotation is off besides the heading, rad (0.7 deg): inclination, slip, mounting.
constexpr double kOffRad = 0.012;
/// How far skin of which nothing is known turns, rad (10 deg).
constexpr double kUnknownRad = 0.17;

}  // namespace

SkinTurns::SkinTurns(const sensor::SkinMotion& motion, std::span<const std::string> face_sensors)
    : seen_(face_sensors.size()), readings_(face_sensors.size()), column_(face_sensors.size() + 1) {
  const auto size = static_cast<Index>(3 * face_sensors.size());
  mean_rad_ = beyond_rad_ = right_ = unit_ = Eigen::VectorXd::Zero(size);
  normal_ = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(size, motion.factor_deg.cols());
  Eigen::VectorXd own2 = Eigen::VectorXd::Constant(size, kOffRad * kOffRad);
  for (std::size_t i = 0; i < face_sensors.size(); ++i) {
    const auto at = static_cast<Index>(3 * i);
    const auto found = std::ranges::find(motion.sensors, face_sensors[i]);
    if (found == motion.sensors.end()) {
      own2.segment<3>(at).setConstant(kUnknownRad * kUnknownRad);
      continue;
    }
    const auto from = static_cast<Index>(3 * (found - motion.sensors.begin()));
    mean_rad_.segment<3>(at) = kRadPerDeg * motion.mean_deg.segment<3>(from);
    factor.middleRows<3>(at) = kRadPerDeg * motion.factor_deg.middleRows<3>(from);
  }
  Eigen::MatrixXd covariance = factor * factor.transpose();
  covariance.diagonal() += own2;
  information_ = covariance.llt().solve(Eigen::MatrixXd::Identity(size, size));
  // Upright and all there: what a sigma is before the first frame.
  for (std::size_t i = 0; i < face_sensors.size(); ++i)
    see(i, mean_rad_.segment<3>(static_cast<Index>(3 * i)));
  solve(Vec3::UnitY());
}

void SkinTurns::clear() {
  seen_.assign(seen_.size(), false);
  beyond_rad_.setZero();
}

void SkinTurns::see(std::size_t sensor, const Vec3& rotation_vector) {
  const auto at = static_cast<Index>(3 * sensor);
  seen_[sensor] = true;
  beyond_rad_.segment<3>(at) = rotation_vector - mean_rad_.segment<3>(at);
}

void SkinTurns::solve(const Vec3& up) {
  const std::size_t n = seen_.size();
  column_[0] = 0;
  for (std::size_t i = 0; i < n; ++i) column_[i + 1] = column_[i] + (seen_[i] ? 1 : 3);
  const Index columns = column_[n];

  // Least squares of what was seen, weighed by the information: normal matrix and right-hand side.
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Index>(3 * i);
    const Vec3 told = information_.middleRows<3>(row) * beyond_rad_;
    if (seen_[i])
      right_[column_[i]] = up.dot(told);
    else
      right_.segment<3>(column_[i]) = told;
    for (std::size_t j = 0; j < n; ++j) {
      const Mat3 block = information_.block<3, 3>(row, static_cast<Index>(3 * j));
      if (seen_[i] && seen_[j])
        normal_(column_[i], column_[j]) = up.dot(block * up);
      else if (seen_[i])
        normal_.block<1, 3>(column_[i], column_[j]) = up.transpose() * block;
      else if (seen_[j])
        normal_.block<3, 1>(column_[i], column_[j]) = block * up;
      else
        normal_.block<3, 3>(column_[i], column_[j]) = block;
    }
  }
  Eigen::Ref<Eigen::MatrixXd> square = normal_.topLeftCorner(columns, columns);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(square);
  auto right = right_.head(columns);
  factors.solveInPlace(right);
  for (std::size_t i = 0; i < n; ++i) {
    if (!seen_[i]) continue;
    // The diagonal of the inverse: |L^-1 e_i|^2.
    auto unit = unit_.head(columns);
    unit.setZero();
    unit[column_[i]] = 1;
    factors.matrixL().solveInPlace(unit);
    readings_[i] = {right_[column_[i]], unit.norm()};
  }
}

}  // namespace mien::imu
