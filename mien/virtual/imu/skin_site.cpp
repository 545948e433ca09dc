#include "mien/virtual/imu/skin_site.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "mien/builtin_face/builtin_face.h"
#include "mien/face/surface_point.h"

namespace mien::virt {
namespace {

/// A mesh with at least this many vertices in a patch is as fine as ICT's; a coarser one is sampled.
constexpr std::size_t kFinePatch = 12;
constexpr int kPatchSamples = 64;
/// Half a millimetre, as a standard deviation.
constexpr double kThinnestPatchM = 0.0005;

using face::align_landmarks;
using face::nearest_on_skin;
using face::neutral_position;
using face::skin_triangles;
using face::SurfacePoint;

Vec3 neutral(const face::Face& face, std::uint32_t vertex) {
  return face.neutral_m[vertex].cast<double>();
}

std::vector<std::uint32_t> triangles_near(const face::Face& face, std::span<const std::uint32_t> triangles,
                                          const Vec3& p, double radius_m) {
  std::vector<std::uint32_t> near;
  for (const std::uint32_t t : triangles) {
    const bool any = std::ranges::any_of(face.triangles[t], [&](std::uint32_t v) {
      return (neutral(face, v) - p).squaredNorm() < radius_m * radius_m;
    });
    if (any) near.push_back(t);
  }
  return near;
}

/// The patch's points: the vertices within the radius, or points spread evenly (a sunflower in the tangent
/// plane, put back onto the surface) where the mesh is coarser than that.
std::vector<SurfacePoint> patch_points(const face::Face& face, std::span<const std::uint32_t> near,
                                       const Vec3& centre, const Vec3& normal) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t t : near)
    for (const std::uint32_t v : face.triangles[t])
      if ((neutral(face, v) - centre).norm() <= kPatchRadiusM) vertices.push_back(v);
  std::ranges::sort(vertices);
  vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
  std::vector<SurfacePoint> points;
  if (vertices.size() >= kFinePatch) {
    for (const std::uint32_t v : vertices) points.push_back({{v, v, v}, {1, 0, 0}});
    return points;
  }
  const Vec3 side = (std::abs(normal.y()) < 0.9 ? Vec3::UnitY() : Vec3::UnitX()).cross(normal).normalized();
  const Vec3 up = normal.cross(side);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < kPatchSamples; ++i) {
    const double r = kPatchRadiusM * std::sqrt((i + 0.5) / kPatchSamples);
    const Vec3 p = centre + r * (std::cos(golden * i) * side + std::sin(golden * i) * up);
    points.push_back(nearest_on_skin(face, near, p));
  }
  return points;
}

Result<SkinSite> make_site(const face::Face& face, std::span<const std::uint32_t> triangles,
                           const Vec3& target) {
  const std::vector<std::uint32_t> around = triangles_near(face, triangles, target, 0.04);
  const SurfacePoint centre = nearest_on_skin(face, around.empty() ? triangles : around, target);
  const Vec3 centre_m = neutral_position(face, centre);
  const auto& [a, b, c] = centre.vertex;
  const Vec3 facet = (neutral(face, b) - neutral(face, a)).cross(neutral(face, c) - neutral(face, a));
  const std::vector<std::uint32_t> near = triangles_near(face, triangles, centre_m, 0.02);
  const std::vector<SurfacePoint> points = patch_points(face, near, centre_m, facet.normalized());

  SkinSite site;
  site.normal = facet.normalized();
  Vec3 mean = Vec3::Zero();
  for (const SurfacePoint& p : points) mean += neutral_position(face, p);
  mean /= static_cast<double>(points.size());
  site.position_m = mean;
  std::vector<Vec3> from(points.size());
  site.covariance.setZero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    from[i] = neutral_position(face, points[i]) - mean;
    site.covariance += from[i] * from[i].transpose();
  }
  // Its two widths: a patch that is a point or a line has no orientation.
  const Vec3 spread = Eigen::SelfAdjointEigenSolver<Mat3>(
                          site.covariance / static_cast<double>(points.size()), Eigen::EigenvaluesOnly)
                          .eigenvalues();
  if (!(spread[1] > kThinnestPatchM * kThinnestPatchM))
    return fail(ErrorCode::unsupported, "there is no skin wide enough for a sensor at its site", face.name,
                "use a face with a closed skin there");
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const face::Shape& shape = face.shapes[k];
    const auto delta = [&](std::uint32_t vertex) -> Vec3 {
      const auto found = std::ranges::lower_bound(shape.vertex, vertex);
      if (found == shape.vertex.end() || *found != vertex) return Vec3::Zero();
      return shape.delta_m[static_cast<std::size_t>(found - shape.vertex.begin())].cast<double>();
    };
    Mat3 covariance = Mat3::Zero();
    Vec3 shift = Vec3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec3 moved = Vec3::Zero();
      for (std::size_t c3 = 0; c3 < 3; ++c3)
        if (points[i].weight[c3] != 0) moved += points[i].weight[c3] * delta(points[i].vertex[c3]);
      covariance += from[i] * moved.transpose();
      shift += moved;
    }
    site.shape_covariance[k] = covariance;
    site.shape_shift_m[k] = shift / static_cast<double>(points.size());
  }
  return site;
}

/// The mount's site on the default built-in head.
std::optional<Vec3> builtin_site(const sensor::Mount& mount) {
  if (mount.position_m) return mount.position_m;
  for (const builtin_face::BuiltinSite& site : builtin_face::builtin_sites())
    if (site.name == mount.name) return site.position_m;
  return std::nullopt;
}

/// The same spot of skin on another identity of the built-in head: all of them share their triangles.
Vec3 carry_to_identity(const Vec3& site, const face::Face& face) {
  const std::vector<std::uint32_t> triangles = skin_triangles(builtin_face::default_builtin());
  return neutral_position(face, nearest_on_skin(builtin_face::default_builtin(), triangles, site));
}

}  // namespace

Quat SkinSite::rotation(const face::BlendshapeWeights& weights) const {
  Mat3 c = covariance;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (weights[k] != 0) c += static_cast<double>(weights[k]) * shape_covariance[k];
  return fit_rotation(c);
}

Vec3 SkinSite::position(const face::BlendshapeWeights& weights) const {
  Vec3 p = position_m;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (weights[k] != 0) p += static_cast<double>(weights[k]) * shape_shift_m[k];
  return p;
}

Result<std::vector<SkinSite>> skin_sites(const face::Face& face, const sensor::Rig& rig,
                                         std::span<const Vec3> offset_m) {
  if (!offset_m.empty() && offset_m.size() != rig.sensors.size())
    return fail(ErrorCode::mismatch, "there must be one placement offset a sensor", rig.name);
  const bool is_ict = face.origin == face::Origin::ict;
  const bool is_builtin = face.origin == face::Origin::builtin;
  if (!is_ict && !is_builtin && !face.has_landmarks)
    return fail(ErrorCode::not_found, "the face has no landmarks, so the rig's sites cannot be found on it",
                face.name, "use the built-in face, an ICT-FaceKit folder, or a head with 68 landmarks");
  const std::vector<std::uint32_t> triangles = skin_triangles(face);
  Eigen::Affine3d from_builtin = Eigen::Affine3d::Identity();
  if (!is_builtin && face.has_landmarks)
    from_builtin = align_landmarks(builtin_face::default_builtin(), face);
  std::vector<SkinSite> sites;
  for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
    const sensor::Mount& mount = rig.sensors[s];
    Vec3 target;
    if (is_ict && mount.ict_vertex >= 0) {
      if (static_cast<std::size_t>(mount.ict_vertex) >= face.neutral_m.size())
        return fail(ErrorCode::out_of_range,
                    fmt::format("vertex {} is not on the ICT mesh", mount.ict_vertex), mount.name);
      target = neutral(face, static_cast<std::uint32_t>(mount.ict_vertex));
    } else {
      const std::optional<Vec3> site = builtin_site(mount);
      if (!site)
        return fail(ErrorCode::not_found,
                    fmt::format("the site of sensor {} is unknown on this face", mount.name), rig.name,
                    "give the sensor a position_m in the rig file");
      target = is_builtin ? carry_to_identity(*site, face) : Vec3(from_builtin * *site);
    }
    if (!offset_m.empty()) target += offset_m[s];
    MIEN_TRY_ASSIGN(sites.emplace_back(), make_site(face, triangles, target));
    sites.back().sensor = mount.name;
  }
  return sites;
}

Eigen::MatrixXd rotation_slopes(std::span<const SkinSite> sites, float step) {
  Eigen::MatrixXd slopes(3 * static_cast<Eigen::Index>(sites.size()),
                         static_cast<Eigen::Index>(face::kShapeCount));
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    face::BlendshapeWeights weights;
    weights[k] = step;
    for (std::size_t s = 0; s < sites.size(); ++s)
      slopes.block<3, 1>(3 * static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(k)) =
          log_rotation(sites[s].rotation(weights)) / static_cast<double>(step);
  }
  return slopes;
}

std::vector<Vec3> draw_placement(const sensor::Rig& rig, double sigma_m, Random random) {
  std::vector<Vec3> offsets_m(rig.sensors.size());
  for (Vec3& offset : offsets_m) offset = sigma_m * Vec3{random.normal(), random.normal(), random.normal()};
  return offsets_m;
}

std::vector<SkinSite> draw_turns(const std::vector<SkinSite>& sites, double sigma_rad, Random random) {
  std::vector<SkinSite> drawn = sites;
  for (SkinSite& site : drawn) {
    const Vec3 axis = random.direction();
    const Mat3 turn = exp_rotation(sigma_rad * random.normal() * axis).toRotationMatrix();
    site.normal = turn * site.normal;
    site.covariance = turn * site.covariance * turn.transpose();
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      site.shape_covariance[k] = turn * site.shape_covariance[k] * turn.transpose();
      site.shape_shift_m[k] = turn * site.shape_shift_m[k];
    }
  }
  return drawn;
}

std::vector<SkinSite> draw_kinematics(const std::vector<SkinSite>& sites, const KinematicsSpread& spread,
                                      Random random) {
  std::vector<SkinSite> drawn = sites;
  for (SkinSite& site : drawn) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double gain = std::max(0.1, 1 + spread.gain * random.normal());
      // Where the skin goes: the displacement field's direction.
      const Mat3 direction = exp_rotation(spread.direction_rad / std::sqrt(3.0) *
                                          Vec3{random.normal(), random.normal(), random.normal()})
                                 .toRotationMatrix();
      // Which way the fold lies: the whole field turned about the normal.
      const Mat3 about =
          exp_rotation(spread.direction_rad * random.normal() * site.normal).toRotationMatrix();
      site.shape_covariance[k] =
          gain * about * site.shape_covariance[k] * about.transpose() * direction.transpose();
      site.shape_shift_m[k] = gain * direction * about * site.shape_shift_m[k];
    }
  }
  return drawn;
}

}  // namespace mien::virt
