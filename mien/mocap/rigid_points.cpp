#include "mien/mocap/rigid_points.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "mien/mocap/marker_track.h"

namespace mien::mocap {
namespace {

constexpr std::size_t kReferences = 8;
constexpr std::size_t kFewest = 3;
constexpr double kSigmas = 4;
constexpr double kAlwaysM = 1e-3;
/// Least extent across the line of points, m: collinear points leave the rotation about it undetermined.
constexpr double kLineM = 5e-3;
/// Least slack, m: markers sit on skin, and no single one may dominate the fit, since it may be wrong.
constexpr double kLeastSlackM = 1e-3;
/// Standard deviation of a marker's motion by expressions over the root sum of squares of all shapes'
/// displacements. Measured on the built-in face, five minutes of expressions, range of motion and speech: 0.3
/// to 0.42.
constexpr double kShareOfShapes = 0.35;

}  // namespace

std::optional<Eigen::Isometry3d> fit_rigid(const RigidPoints& body, std::span<const Vec3f> seen) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < std::min(body.place_m.size(), seen.size()); ++i)
    if (is_seen(seen[i])) used.push_back(i);
  while (used.size() >= kFewest) {
    const auto weight = [&](std::size_t i) { return 1e-6 / (body.slack_m[i] * body.slack_m[i]); };
    double sum = 0;
    Vec3 from = Vec3::Zero(), to = Vec3::Zero();
    for (const std::size_t i : used) {
      sum += weight(i);
      from += weight(i) * seen[i].cast<double>();
      to += weight(i) * body.place_m[i];
    }
    from /= sum;
    to /= sum;
    Mat3 covariance = Mat3::Zero(), spread = Mat3::Zero();
    for (const std::size_t i : used) {
      const Vec3 p = seen[i].cast<double>() - from;
      const Vec3 q = body.place_m[i] - to;
      covariance += weight(i) * q * p.transpose();
      spread += q * q.transpose();
    }
    // The body's second largest extent decides whether the rotation is determined.
    const Eigen::JacobiSVD<Mat3> extent(spread);
    if (std::sqrt(extent.singularValues()[1]) < kLineM) return std::nullopt;
    const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vec3 signs = Vec3::Ones();
    signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Mat3 turn = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    Eigen::Isometry3d fit = Eigen::Isometry3d::Identity();
    fit.linear() = turn;
    fit.translation() = to - turn * from;

    auto worst = used.end();
    double most = 1;
    for (auto i = used.begin(); i != used.end(); ++i) {
      const double off = (fit * seen[*i].cast<double>() - body.place_m[*i]).norm();
      const double share = off / (kSigmas * body.slack_m[*i] + kAlwaysM);
      if (share <= most) continue;
      most = share;
      worst = i;
    }
    if (worst == used.end()) return fit;
    used.erase(worst);
  }
  return std::nullopt;
}

std::vector<ReferenceMarker> reference_markers(const builtin_face::PlacedMarkers& placed) {
  std::vector<ReferenceMarker> all;
  for (std::size_t i = 0; i < placed.count(); ++i) {
    const auto rows = placed.shapes_m().middleRows<3>(3 * static_cast<Eigen::Index>(i));
    all.push_back({i, std::max(kLeastSlackM, kShareOfShapes * rows.norm())});
  }
  std::ranges::sort(all, [](const ReferenceMarker& a, const ReferenceMarker& b) {
    return a.slack_m != b.slack_m ? a.slack_m < b.slack_m : a.marker < b.marker;
  });
  all.resize(std::min(all.size(), kReferences));
  return all;
}

}  // namespace mien::mocap
