#include "mien/virtual/imu/skin_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mien/core/units.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::virt {
namespace {

using Eigen::Index;

constexpr double kPlacementM = 3e-3;
/// Frames between two that are looked at; the next ones tell nothing new.
constexpr std::size_t kEvery = 30;

/// Of one performer's rotation vectors, degrees.
struct MotionSums {
  double count = 0;
  Eigen::VectorXd first;
  Eigen::MatrixXd second;
};

Result<MotionSums> perform_one(const SkinMotionRequest& request, const sensor::Rig& rig,
                               std::size_t performer) {
  const Random root = Random(request.seed).fork("skin motion", performer);
  // Even shares that any number of performers has, from the golden ratio.
  const double share = std::fmod(static_cast<double>(performer) * (std::numbers::phi - 1), 1.0);
  const VirtualPerson person = draw_person(root);
  const face::Motion motion = draw_motion(request.seconds, person.style, root);
  const std::vector<Vec3> placement_m = draw_placement(rig, share * kPlacementM, root.fork("placement"));
  MIEN_TRY_ASSIGN(std::vector<SkinSite> sites, skin_sites(person.face, rig, placement_m));
  sites = draw_kinematics(sites, KinematicsSpread().times(share), root.fork("kinematics"));

  const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
  MotionSums sums;
  Eigen::VectorXd turns(static_cast<Index>(3 * face_sensors.size()));
  sums.first.setZero(turns.size());
  sums.second.setZero(turns.size(), turns.size());
  for (std::size_t f = 0; f < motion.frames.size(); f += kEvery) {
    for (std::size_t i = 0; i < face_sensors.size(); ++i)
      turns.segment<3>(static_cast<Index>(3 * i)) =
          kDegPerRad * log_rotation(sites[face_sensors[i]].rotation(motion.frames[f].weights));
    sums.first += turns;
    sums.second += turns * turns.transpose();
    ++sums.count;
  }
  return sums;
}

template <class Matrix>
Matrix hundredths(const Matrix& degrees) {
  return (100 * degrees).array().round() / 100;
}

}  // namespace

Result<sensor::SkinMotion> study_skin_motion(const SkinMotionRequest& request, const sensor::Rig& rig,
                                             const Progress& progress) {
  if (rig.face_sensors().empty())
    return fail(ErrorCode::bad_usage, "the rig has no sensor on the face", rig.name);
  std::vector<MotionSums> sums(static_cast<std::size_t>(std::max(request.performers, 1)));
  MIEN_TRY(for_each_performer(sums.size(), request.threads, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(sums[p], perform_one(request, rig, p));
    return {};
  }));
  MotionSums all = sums.front();
  for (std::size_t p = 1; p < sums.size(); ++p) {
    all.count += sums[p].count;
    all.first += sums[p].first;
    all.second += sums[p].second;
  }
  if (!(all.count > 0)) return fail(ErrorCode::bad_usage, "the performances have no frames", rig.name);
  const Eigen::VectorXd mean = all.first / all.count;
  Eigen::MatrixXd covariance = all.second / all.count - mean * mean.transpose();
  covariance.diagonal().array() += 0.05 * 0.05;  // What a triangle of hundredths cannot tell from nothing.
  return sensor::SkinMotion{rig.face_sensor_names(), hundredths(mean),
                            hundredths(Eigen::MatrixXd(covariance.llt().matrixL()))};
}

}  // namespace mien::virt
