#include "lab/imu/placement/misplacement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/imu/sensor_bound.h"

namespace mien::lab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Of squared errors against the one of sensors in their places.
MisplacementCost cost_of(const std::vector<double>& squared_errors, double in_place) {
  MisplacementCost cost{.mean = 0, .worst = -1};
  for (const double squared_error : squared_errors) {
    const double more = std::sqrt(squared_error / in_place) - 1;
    cost.mean += more / static_cast<double>(squared_errors.size());
    cost.worst = std::max(cost.worst, more);
  }
  return cost;
}

/// The slopes with one sensor's three rows by others.
MatrixXd with_rows(MatrixXd slopes, std::size_t sensor, const MatrixXd& rows) {
  slopes.middleRows(3 * static_cast<Index>(sensor), 3) = rows;
  return slopes;
}

/// Two unit vectors in the skin: up, and aside of it.
std::array<Vec3, 2> in_skin(const Vec3& normal) {
  const Vec3 along = std::abs(normal.y()) < 0.9 ? Vec3::UnitY() : Vec3::UnitZ();
  const Vec3 up = (along - along.dot(normal) * normal).normalized();
  return {up, up.cross(normal)};
}

}  // namespace

double mismatched_squared_error(const MatrixXd& gram, const MatrixXd& believed, const MatrixXd& truth,
                                double prior, double noise_rad) {
  const MatrixXd covariance = posterior_covariance(believed, prior, noise_rad);
  const MatrixXd gain = covariance * believed.transpose() / (noise_rad * noise_rad);
  const MatrixXd left = MatrixXd::Identity(covariance.rows(), covariance.cols()) - gain * truth;
  const MatrixXd error =
      prior * prior * left * left.transpose() + noise_rad * noise_rad * gain * gain.transpose();
  return expected_squared_error(gram, error);
}

Result<std::vector<SiteMisplacement>> misplacement_costs(const face::Face& face,
                                                         const std::vector<SensorCandidate>& set,
                                                         const MatrixXd& gram,
                                                         const PlacementSettings& settings,
                                                         const MisplacementRequest& request) {
  const sensor::Rig rig = sites_rig(set);
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> sites, virt::skin_sites(face, rig));
  const MatrixXd slopes = virt::rotation_slopes(sites, kBoundStep);
  // All are moved at once, and then looked at one by one.
  std::vector<MatrixXd> moved;
  for (std::size_t d = 0; d < request.directions; ++d) {
    const double angle =
        2 * std::numbers::pi * static_cast<double>(d) / static_cast<double>(request.directions);
    std::vector<Vec3> offset_m;
    for (const virt::SkinSite& site : sites) {
      const auto [up, aside] = in_skin(site.normal);
      offset_m.push_back(request.shift_m * (std::cos(angle) * up + std::sin(angle) * aside));
    }
    MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> there, virt::skin_sites(face, rig, offset_m));
    moved.push_back(virt::rotation_slopes(there, kBoundStep));
  }
  const auto believing = [&](const MatrixXd& truth) {
    return mismatched_squared_error(gram, slopes, truth, settings.prior, settings.noise_rad);
  };
  const auto knowing = [&](const MatrixXd& truth) {
    return expected_squared_error(gram, posterior_covariance(truth, settings.prior, settings.noise_rad));
  };
  const double in_place = knowing(slopes);

  std::vector<SiteMisplacement> costs;
  for (std::size_t s = 0; s < set.size(); ++s) {
    const auto row = 3 * static_cast<Index>(s);
    std::vector<double> shifted, known, turned, tilted;
    for (const MatrixXd& there : moved) {
      const MatrixXd truth = with_rows(slopes, s, there.middleRows(row, 3));
      shifted.push_back(believing(truth));
      known.push_back(knowing(truth));
    }
    const auto [up, aside] = in_skin(sites[s].normal);
    const auto turn_about = [&](const Vec3& axis, std::vector<double>& squared_errors) {
      for (const double angle : {request.turn_rad, -request.turn_rad}) {
        const Mat3 turn = exp_rotation(angle * axis).toRotationMatrix();
        squared_errors.push_back(believing(with_rows(slopes, s, turn * slopes.middleRows(row, 3))));
      }
    };
    turn_about(sites[s].normal, turned);
    turn_about(up, tilted);
    turn_about(aside, tilted);
    costs.push_back({.sensor = set[s].name,
                     .shifted = cost_of(shifted, in_place),
                     .shifted_known = cost_of(known, in_place),
                     .turned = cost_of(turned, in_place),
                     .tilted = cost_of(tilted, in_place)});
  }
  return costs;
}

}  // namespace mien::lab
