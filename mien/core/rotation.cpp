#include "mien/core/rotation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

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

std::array<float, 4> wxyz_of(const Quat& q) {
  const Eigen::Quaternionf narrow = q.cast<float>();
  return {narrow.w(), narrow.x(), narrow.y(), narrow.z()};
}

Quat quat_of(const std::array<float, 4>& wxyz) {
  return Quat(double{wxyz[0]}, double{wxyz[1]}, double{wxyz[2]}, double{wxyz[3]});
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

namespace {

/// Below this share of the cube of the largest eigenvalue, the derivative of the characteristic polynomial
/// there says that another eigenvalue is near: points almost on a line, and mirror images.
constexpr double kSimpleRoot = 0.01;

/// The vector at right angles to three of four dimensions: their cross product.
Eigen::Vector4d normal_to(const Eigen::Matrix<double, 3, 4>& rows) {
  Eigen::Vector4d out;
  for (Eigen::Index k = 0; k < 4; ++k) {
    Mat3 others;
    for (Eigen::Index j = 0; j < 3; ++j) others.col(j) = rows.col(j < k ? j : j + 1);
    out[k] = k % 2 == 0 ? others.determinant() : -others.determinant();
  }
  return out;
}

/// Horn 1987 (doi:10.1364/JOSAA.4.000629): the rotation is the eigenvector of the largest eigenvalue of a
/// symmetric 4 x 4 matrix. That eigenvalue by Newton's method on the characteristic polynomial, from above
/// (Theobald 2005, doi:10.1107/S0108767305015266). None where another eigenvalue is near.
std::optional<Quat> fit_by_quaternion(const Mat3& c) {
  Eigen::Matrix4d horn;
  horn << c.trace(), c(1, 2) - c(2, 1), c(2, 0) - c(0, 2), c(0, 1) - c(1, 0),  //
      0, c(0, 0) - c(1, 1) - c(2, 2), c(0, 1) + c(1, 0), c(2, 0) + c(0, 2),    //
      0, 0, c(1, 1) - c(0, 0) - c(2, 2), c(1, 2) + c(2, 1),                    //
      0, 0, 0, c(2, 2) - c(0, 0) - c(1, 1);
  horn = Eigen::Matrix4d(horn.selfadjointView<Eigen::Upper>());
  const double c2 = -2 * c.squaredNorm(), c1 = -8 * c.determinant(), c0 = horn.determinant();
  double largest = std::sqrt(3.0) * c.norm();  // At least the sum of the singular values.
  double slope = 0;
  bool converged = false;
  for (int i = 0; i < 20 && !converged; ++i) {
    const double square = largest * largest;
    slope = (4 * square + 2 * c2) * largest + c1;
    if (!(slope > kSimpleRoot * square * largest)) return std::nullopt;
    const double step = (((square + c2) * largest + c1) * largest + c0) / slope;
    largest -= step;
    converged = std::abs(step) <= 1e-14 * largest;
  }
  if (!converged) return std::nullopt;
  horn.diagonal().array() -= largest;
  // The cofactors of row i are `slope` times q_i q: of some row, at least half as long as that.
  for (Eigen::Index i = 0; i < 4; ++i) {
    Eigen::Matrix<double, 3, 4> rows;
    for (Eigen::Index j = 0; j < 3; ++j) rows.row(j) = horn.row(j < i ? j : j + 1);
    const Eigen::Vector4d q = normal_to(rows);
    if (q.norm() > 0.4 * slope) return canonical(Quat(q[0], q[1], q[2], q[3]));
  }
  return std::nullopt;
}

}  // namespace

Quat fit_rotation(const Mat3& covariance_from_to) {
  if (const std::optional<Quat> fitted = fit_by_quaternion(covariance_from_to)) return *fitted;
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
