#include "mien/imu/level_change.h"

#include <algorithm>
#include <cmath>

namespace mien::imu {
namespace {

/// Share of the usual scatter that the changes begin with, for how many seconds that counts, and how many are
/// remembered.
constexpr double kPriorShare = 0.25, kPriorS = 60, kMemoryS = 1200;
/// No direction is steadier than this, rad.
constexpr double kLeastRad = 1e-6;
/// One direction counts for five standard deviations at most.
constexpr double kMostSquare = 25;
/// More than this share of the squared change is one sensor's, or common to all: an adhesive's.
constexpr double kOneSensorShare = 0.8, kCommonShare = 0.6;

}  // namespace

void UsualChanges::start(const Eigen::MatrixXd& usual_rad2) {
  moment_rad2_ = kPriorShare * usual_rad2;
  seconds_ = 0;
}

void UsualChanges::add(const Eigen::VectorXd& change_rad) {
  seconds_ = std::min(seconds_ + 1, kMemoryS);
  const double share = 1 / (kPriorS + seconds_);
  moment_rad2_ *= 1 - share;
  moment_rad2_.noalias() += share * change_rad * change_rad.transpose();
}

double UsualChanges::along_rad(const Eigen::Ref<const Eigen::VectorXd>& direction) {
  product_rad2_.noalias() = moment_rad2_ * direction;
  return std::max(kLeastRad, std::sqrt(std::max(0.0, direction.dot(product_rad2_))));
}

void JointChange::add(double deviations) {
  squares_ += std::min(kMostSquare, deviations * deviations);
  ++count_;
}

bool JointChange::beyond(double gate) const {
  return squares_ > count_ + gate * std::sqrt(2 * count_);
}

bool is_displacement(const Eigen::VectorXd& change_rad) {
  const double all_rad2 = change_rad.squaredNorm();
  double most_rad2 = 0, sensors = 0;
  Eigen::Vector3d sum_rad = Eigen::Vector3d::Zero();
  for (Eigen::Index at = 0; at < change_rad.size(); at += 3) {
    const double one_rad2 = change_rad.segment<3>(at).squaredNorm();
    if (one_rad2 == 0) continue;  // It is absent.
    most_rad2 = std::max(most_rad2, one_rad2);
    sum_rad += change_rad.segment<3>(at);
    ++sensors;
  }
  return sensors > 1 && (most_rad2 > kOneSensorShare * all_rad2 ||
                         sum_rad.squaredNorm() > kCommonShare * sensors * all_rad2);
}

}  // namespace mien::imu
