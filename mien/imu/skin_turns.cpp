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
/// Of a sensor that was not seen, rad^2: it says nothing.
constexpr double kUnseenRad2 = 1e6;

}  // namespace

SkinTurns::SkinTurns(const sensor::SkinMotion& motion, std::span<const std::string> face_sensors)
    : seen_(face_sensors.size()), readings_(face_sensors.size()) {
  const auto sensors = static_cast<Index>(face_sensors.size()), size = 3 * sensors;
  mean_rad_ = beyond_rad_ = noise_rad2_ = Eigen::VectorXd::Zero(size);
  factor_ = Eigen::MatrixXd::Zero(size, size);
  design_ = Eigen::MatrixXd::Zero(size, sensors);
  normal_ = Eigen::MatrixXd::Zero(sensors, sensors);
  right_ = unit_ = Eigen::VectorXd::Zero(sensors);
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
    mean_rad_.segment<3>(at) = kRadPerDeg * motion.mean_deg.segment<3>(from);
    muscles.middleRows<3>(at) = kRadPerDeg * motion.factor_deg.middleRows<3>(from);
  }
  covariance_rad2_ = muscles * muscles.transpose();
  covariance_rad2_.diagonal() += own_rad2;
  for (std::size_t i = 0; i < face_sensors.size(); ++i)
    see(i, mean_rad_.segment<3>(static_cast<Index>(3 * i)));
  solve(Vec3::UnitY());
  for (const Reading& reading : readings_) usual_sigma_rad_.push_back(reading.sigma_rad);
}

void SkinTurns::clear() {
  seen_.assign(seen_.size(), false);
  beyond_rad_.setZero();
  noise_rad2_.setConstant(kUnseenRad2);
}

void SkinTurns::see(std::size_t sensor, const Vec3& rotation_vector, double tilt_sigma_rad) {
  const auto at = static_cast<Index>(3 * sensor);
  seen_[sensor] = true;
  beyond_rad_.segment<3>(at) = rotation_vector - mean_rad_.segment<3>(at);
  noise_rad2_.segment<3>(at).setConstant(tilt_sigma_rad * tilt_sigma_rad);
}

void SkinTurns::solve(const Vec3& up) {
  // beyond = design * errors + noise of the covariance S. With S = L L^T both sides are multiplied by L^-1.
  factor_ = covariance_rad2_;
  factor_.diagonal() += noise_rad2_;
  Eigen::Ref<Eigen::MatrixXd> all(factor_);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> whiten(all);
  design_.setZero();
  for (Index i = 0; i < design_.cols(); ++i) design_.block<3, 1>(3 * i, i) = up;
  whiten.matrixL().solveInPlace(design_);
  whiten.matrixL().solveInPlace(beyond_rad_);
  normal_.noalias() = design_.transpose() * design_;
  right_.noalias() = design_.transpose() * beyond_rad_;
  Eigen::Ref<Eigen::MatrixXd> square(normal_);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(square);
  factors.solveInPlace(right_);
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!seen_[i]) continue;
    // The diagonal of the inverse: |L^-1 e_i|^2.
    unit_.setZero();
    unit_[static_cast<Index>(i)] = 1;
    factors.matrixL().solveInPlace(unit_);
    readings_[i] = {right_[static_cast<Index>(i)], unit_.norm()};
  }
}

}  // namespace mien::imu
