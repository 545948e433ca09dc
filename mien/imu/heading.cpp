#include "mien/imu/heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::imu {
namespace {

constexpr double kPi = std::numbers::pi;
/// Errors of successive nods are correlated: independent measurements that a prologue counts for.
constexpr double kIndependentLooks = 2;

}  // namespace

double wrap_heading(double angle_rad) {
  const double wrapped_rad = std::remainder(angle_rad, 2 * kPi);
  return wrapped_rad <= -kPi ? kPi : wrapped_rad;
}

Quat heading_turn(double angle_rad) {
  return Quat(Eigen::AngleAxisd(angle_rad, Vec3::UnitY()));
}

void HeadingSums::add(const Quat& q_world_ear, const Quat& q_world_face) {
  const Mat3 ear = q_world_ear.toRotationMatrix().transpose();
  const Mat3 face = q_world_face.toRotationMatrix();
  // Z = y y^T + cos (1 - y y^T) + sin [y]x, with [y]x face = (row z, 0, -row x).
  const Mat3 vertical = ear.col(1) * face.row(1);
  constant_ += vertical;
  cosine_ += ear * face - vertical;
  sine_ += ear.col(0) * face.row(2) - ear.col(2) * face.row(0);
  up_sum_ += ear.col(1);
  ++count_;
}

HeadingSums& HeadingSums::operator+=(const HeadingSums& other) {
  constant_ += other.constant_;
  cosine_ += other.cosine_;
  sine_ += other.sine_;
  up_sum_ += other.up_sum_;
  count_ += other.count_;
  return *this;
}

double HeadingSums::squared_sum(double heading_rad) const {
  return (constant_ + std::cos(heading_rad) * cosine_ + std::sin(heading_rad) * sine_).squaredNorm();
}

Quat HeadingSums::mean(double heading_rad) const {
  // The rotation closest to the sum of matrices: fit_rotation takes the transpose, "from" to "to".
  const Mat3 sum = constant_ + std::cos(heading_rad) * cosine_ + std::sin(heading_rad) * sine_;
  return fit_rotation(Mat3(sum.transpose()));
}

double HeadingSums::spread(double heading_rad) const {
  if (count_ == 0) return 0;
  // Sum |P - mean|_F^2 = 3 n - |sum P|^2 / n, and a turn by an angle a is 2 a^2 of it.
  const double n = static_cast<double>(count_);
  return std::sqrt(std::max(0.0, 0.5 * (3.0 - squared_sum(heading_rad) / (n * n))));
}

HeadingSums::Best HeadingSums::find() const {
  Best best;
  best.sigma_rad = kPi;
  if (count_ < 2) return best;
  // The sum of squares is a trigonometric polynomial of degree two: coarse search, then golden section.
  constexpr int kCoarse = 72;
  double top = -1;
  for (int i = 0; i < kCoarse; ++i) {
    const double angle = wrap_heading(2 * kPi * i / kCoarse);
    const double value = squared_sum(angle);
    if (value > top) {
      top = value;
      best.heading_rad = angle;
    }
  }
  double low = best.heading_rad - 2 * kPi / kCoarse;
  double high = best.heading_rad + 2 * kPi / kCoarse;
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 60; ++i) {
    const double a = high - kGolden * (high - low);
    const double b = low + kGolden * (high - low);
    (squared_sum(a) > squared_sum(b) ? high : low) = squared_sum(a) > squared_sum(b) ? b : a;
  }
  best.heading_rad = wrap_heading(0.5 * (low + high));
  const double n = static_cast<double>(count_);
  const double tilt2 = 1 - (up_sum_ / n).squaredNorm();  // Mean square path of the vertical about its mean.
  const double left = std::max(spread(best.heading_rad), 1e-4);
  if (tilt2 > 1e-9) best.sigma_rad = std::min(kPi, left / std::sqrt(tilt2 * kIndependentLooks));
  return best;
}

}  // namespace mien::imu
