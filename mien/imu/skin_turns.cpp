#include "mien/imu/skin_turns.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mien/core/units.h"

namespace mien::imu {
namespace {

using Eigen::Index;

/// What a component of a rotation is off besides the heading, rad (0.7 deg): inclination, slip, mounting.
constexpr double kOffRad = 0.012;
/// How far skin of which nothing is known turns, rad (10 deg).
constexpr double kUnknownRad = 0.17;
/// Of a sensor that was not seen, rad^2: it says nothing.
constexpr double kUnseenRad2 = 1e6;
/// Of a heading, rad^2: its own turn says nothing of how others turn.
constexpr double kHeadingRad2 = 1;
/// A face that hardly moves still strays a little; and one that moves most strongly is told from no more.
constexpr double kLeastStrength = 0.15, kMostStrength = 4;

}  // namespace

SkinTurns::SkinTurns(const sensor::SkinMotion& motion, std::span<const std::string> face_sensors)
    : seen_(face_sensors.size()), readings_(face_sensors.size()) {
  const auto size = static_cast<Index>(3 * face_sensors.size());
  noise_rad2_ = turn_rad_ = weighed_ = Eigen::VectorXd::Zero(size);
  factor_ = inverse_ = Eigen::MatrixXd::Zero(size, size);
  // A face at rest is at neutral, so what counts is the square about that, not about the mean.
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
  for (std::size_t i = 0; i < face_sensors.size(); ++i) see(i, Vec3::Zero());
  solve(Vec3::UnitY());
  for (const SkinReading& reading : readings_) usual_strays_rad2_.push_back(reading.strays_rad2);
}

void SkinTurns::clear() {
  seen_.assign(seen_.size(), false);
  turn_rad_.setZero();
  noise_rad2_.setConstant(kUnseenRad2);
}

void SkinTurns::see(std::size_t sensor, const Vec3& rotation_vector, double tilt_sigma_rad) {
  const auto at = static_cast<Index>(3 * sensor);
  seen_[sensor] = true;
  turn_rad_.segment<3>(at) = rotation_vector;
  noise_rad2_.segment<3>(at).setConstant(tilt_sigma_rad * tilt_sigma_rad);
}

void SkinTurns::solve(const Vec3& up) {
  factor_ = moment_rad2_;
  factor_.diagonal() += noise_rad2_;
  double tilts = 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!seen_[i]) continue;
    tilts += 2;
    const auto at = static_cast<Index>(3 * i);
    // log(exp(e up) exp(r)) to the first order of e and the second of r.
    const Vec3 turn = turn_rad_.segment<3>(at), sideways = turn.cross(up);
    readings_[i].about = up - 0.5 * sideways + turn.cross(sideways) / 12;
    factor_.block<3, 3>(at, at) += kHeadingRad2 * readings_[i].about * readings_[i].about.transpose();
  }
  Eigen::Ref<Eigen::MatrixXd> all(factor_);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(all);
  inverse_.setIdentity();
  factor.solveInPlace(inverse_);
  weighed_.noalias() = inverse_ * turn_rad_;
  // Headings count for nothing in this square, so what is left are two tilts a sensor.
  const double strength =
      std::clamp(std::sqrt(turn_rad_.dot(weighed_) / std::max(tilts, 1.0)), kLeastStrength, kMostStrength);
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!seen_[i]) continue;
    // Of jointly normal numbers with the inverse covariance K, x_i given all others has the covariance
    // K_ii^-1, and x_i less its mean given them is K_ii^-1 (K x)_i.
    const auto at = static_cast<Index>(3 * i);
    SkinReading& reading = readings_[i];
    const Mat3 given_others = inverse_.block<3, 3>(at, at).inverse();
    reading.beyond_rad = given_others * weighed_.segment<3>(at);
    reading.strays_rad2 = given_others - kHeadingRad2 * reading.about * reading.about.transpose();
    reading.strength = strength;
  }
}

}  // namespace mien::imu
