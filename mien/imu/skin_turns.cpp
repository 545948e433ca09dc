#include "mien/imu/skin_turns.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mien/core/units.h"

namespace mien::imu {
namespace {

using Eigen::Index;

/// Standard deviation of a rotation's component besides the heading error, rad (0.7 deg): inclination, creep,
/// mounting.
constexpr double kOffRad = 0.012;
/// Prior standard deviation of a component for sensors without statistics, rad (10 deg).
constexpr double kUnknownRad = 0.17;
/// Variance of a missing sensor's components, rad^2: no information.
constexpr double kUnseenRad2 = 1e6;
/// Prior variance of a heading, rad^2: a turn about the vertical carries no information on other sensors.
constexpr double kHeadingRad2 = 1;
/// Bounds of SkinMeasurement::strength: residuals never vanish, and few sensors overestimate it.
constexpr double kLeastStrength = 0.15, kMostStrength = 4;

}  // namespace

SkinTurns::SkinTurns(const sensor::SkinMotion& motion, std::span<const std::string> face_sensors)
    : present_(face_sensors.size()), measurements_(face_sensors.size()) {
  const auto size = static_cast<Index>(3 * face_sensors.size());
  noise_rad2_ = turn_rad_ = weighed_ = Eigen::VectorXd::Zero(size);
  factor_ = inverse_ = Eigen::MatrixXd::Zero(size, size);
  // A face at rest is at neutral, so the second moment is about neutral, not about the mean.
  Eigen::VectorXd mean_rad = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd muscles = Eigen::MatrixXd::Zero(size, motion.factor_deg.cols());
  Eigen::VectorXd own_rad2 = Eigen::VectorXd::Constant(size, kOffRad * kOffRad);
  for (std::size_t i = 0; i < face_sensors.size(); ++i) {
    const auto at = static_cast<Index>(3 * i);
    const auto found = std::ranges::find(motion.sensors, face_sensors[i]);
    if (found == motion.sensors.end()) {
      own_rad2.segment<3>(at).setConstant(kUnknownRad * kUnknownRad);
      continue;
    }
    const auto from = static_cast<Index>(3 * (found - motion.sensors.begin()));
    mean_rad.segment<3>(at) = kRadPerDeg * motion.mean_deg.segment<3>(from);
    muscles.middleRows<3>(at) = kRadPerDeg * motion.factor_deg.middleRows<3>(from);
  }
  moment_rad2_ = muscles * muscles.transpose() + mean_rad * mean_rad.transpose();
  moment_rad2_.diagonal() += own_rad2;
  clear();
  for (std::size_t i = 0; i < face_sensors.size(); ++i) add(i, Vec3::Zero());
  solve(Vec3::UnitY());
  for (const SkinMeasurement& measurement : measurements_)
    nominal_cov_rad2_.push_back(measurement.residual_cov_rad2);
}

void SkinTurns::clear() {
  present_.assign(present_.size(), false);
  turn_rad_.setZero();
  noise_rad2_.setConstant(kUnseenRad2);
}

void SkinTurns::add(std::size_t sensor, const Vec3& rotation_vector, double tilt_sigma_rad) {
  const auto at = static_cast<Index>(3 * sensor);
  present_[sensor] = true;
  turn_rad_.segment<3>(at) = rotation_vector;
  noise_rad2_.segment<3>(at).setConstant(tilt_sigma_rad * tilt_sigma_rad);
}

void SkinTurns::solve(const Vec3& up) {
  factor_ = moment_rad2_;
  factor_.diagonal() += noise_rad2_;
  double tilts = 0;
  for (std::size_t i = 0; i < present_.size(); ++i) {
    if (!present_[i]) continue;
    tilts += 2;
    const auto at = static_cast<Index>(3 * i);
    // log(exp(e up) exp(r)) to the first order of e and the second of r.
    const Vec3 turn = turn_rad_.segment<3>(at), sideways = turn.cross(up);
    measurements_[i].heading_jacobian = up - 0.5 * sideways + turn.cross(sideways) / 12;
    factor_.block<3, 3>(at, at) +=
        kHeadingRad2 * measurements_[i].heading_jacobian * measurements_[i].heading_jacobian.transpose();
  }
  Eigen::Ref<Eigen::MatrixXd> all(factor_);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(all);
  inverse_.setIdentity();
  factor.solveInPlace(inverse_);
  weighed_.noalias() = inverse_ * turn_rad_;
  // Headings are marginalised, so this is a Mahalanobis distance over two tilts a sensor.
  const double strength =
      std::clamp(std::sqrt(turn_rad_.dot(weighed_) / std::max(tilts, 1.0)), kLeastStrength, kMostStrength);
  for (std::size_t i = 0; i < present_.size(); ++i) {
    if (!present_[i]) continue;
    // Conditional Gaussian with the precision matrix K: x_i given all others has the covariance K_ii^-1, and
    // the residual x_i less its conditional mean is K_ii^-1 (K x)_i.
    const auto at = static_cast<Index>(3 * i);
    SkinMeasurement& measurement = measurements_[i];
    const Mat3 given_others = inverse_.block<3, 3>(at, at).inverse();
    measurement.residual_rad = given_others * weighed_.segment<3>(at);
    measurement.residual_cov_rad2 =
        given_others - kHeadingRad2 * measurement.heading_jacobian * measurement.heading_jacobian.transpose();
    measurement.strength = strength;
  }
}

}  // namespace mien::imu
