#include "mien/core/rotation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace mien {

Quat exp_rotation(const Vec3& vector_rad) {
  const double angle = vector_rad.norm();
  // sin(a/2)/a by its series where the quotient loses digits.
  const double k = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Quat q(std::cos(0.5 * angle), k * vector_rad.x(), k * vector_rad.y(), k * vector_rad.z());
  q.normalize();
  return q;
}

Vec3 log_rotation(const Quat& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double s = v.norm();
  if (s < 1e-9) return 2.0 * v;
  return v * (2.0 * std::atan2(s, sign * q.w()) / s);
}

Quat canonical(const Quat& q) {
  Quat unit = q.normalized();
  if (unit.w() < 0) unit.coeffs() = -unit.coeffs();
  return unit;
}

double angle_between(const Quat& a, const Quat& b) {
  return log_rotation(a.conjugate() * b).norm();
}

Quat twist_about(const Quat& q, const Vec3& axis) {
  const double along = q.vec().dot(axis);
  Quat twist(q.w(), along * axis.x(), along * axis.y(), along * axis.z());
  const double norm = twist.norm();
  if (norm < 1e-12) return Quat::Identity();  // A half turn across the axis: any twist will do.
  twist.coeffs() /= norm;
  return twist;
}

/// An interval this much longer than its neighbour is a gap: 1 / kGap times.
constexpr double kGap = 0.1;

Vec3 interpolate_point(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double u,
                       const KnotSpacing& spacing) {
  const auto& [before, after] = spacing;
  Vec3 slope_b = ((b - a) / before + before * (c - b)) / (1 + before);
  Vec3 slope_c = ((d - c) / after + after * (c - b)) / (1 + after);
  if (std::min(before, after) < kGap) {
    const double steepest = 3 * (c - b).norm();
    for (Vec3* slope : {&slope_b, &slope_c})
      if (const double norm = slope->norm(); norm > steepest) *slope *= steepest / norm;
  }
  const double u2 = u * u;
  const double u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * b + (u3 - 2 * u2 + u) * slope_b + (3 * u2 - 2 * u3) * c +
         (u3 - u2) * slope_c;
}

Quat interpolate_rotation(const Quat& a, const Quat& b, const Quat& c, const Quat& d, double u,
                          const KnotSpacing& spacing) {
  const Quat inverse = b.conjugate();
  return b *
         exp_rotation(interpolate_point(log_rotation(inverse * a), Vec3::Zero(), log_rotation(inverse * c),
                                        log_rotation(inverse * d), u, spacing));
}

Quat fit_rotation(const Mat3& covariance_from_to) {
  const Eigen::JacobiSVD<Mat3> svd(covariance_from_to, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 flip = Mat3::Identity();
  if ((svd.matrixV() * svd.matrixU().transpose()).determinant() < 0) flip(2, 2) = -1;
  const Mat3 rotation = svd.matrixV() * flip * svd.matrixU().transpose();
  return canonical(Quat(rotation));
}

Quat fit_rotation(std::span<const Vec3> from, std::span<const Vec3> to) {
  eigen_assert(from.size() == to.size() && from.size() >= 3);
  Vec3 mean_from = Vec3::Zero();
  Vec3 mean_to = Vec3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    mean_from += from[i];
    mean_to += to[i];
  }
  mean_from /= static_cast<double>(from.size());
  mean_to /= static_cast<double>(from.size());
  Mat3 covariance = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += (from[i] - mean_from) * (to[i] - mean_to).transpose();
  return fit_rotation(covariance);
}

}  // namespace mien
