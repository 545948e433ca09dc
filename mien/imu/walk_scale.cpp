#include "mien/imu/walk_scale.h"

#include <algorithm>

#include "mien/core/quantile.h"

namespace mien::imu {
namespace {

/// One window's ratio counts for so much at most.
constexpr double kMostOfOne = 5;
/// Four times the expected walk. Below 1 the factor never goes: a wearer who holds still would lower it.
constexpr double kMostFactor = 16;
/// A median of fewer sensors is moved by one.
constexpr std::size_t kLeastSensors = 3;

}  // namespace

WalkScale::WalkScale(std::size_t sensors, double window_s, double usual_ratio)
    : window_s_(window_s), usual_ratio_(usual_ratio), moved_(sensors, Vec3::Zero()), expected_(sensors) {
  ratios_.reserve(sensors);
}

void WalkScale::start() {
  std::ranges::fill(moved_, Vec3(Vec3::Zero()));
  std::ranges::fill(expected_, 0.0);
  passed_s_ = 0;
  factor_ = 1;
}

void WalkScale::add(std::size_t sensor, const Vec3& by, double expected) {
  moved_[sensor] += by;
  expected_[sensor] += expected;
}

double WalkScale::advance(double dt_s) {
  passed_s_ += dt_s;
  if (passed_s_ < window_s_) return 1;
  passed_s_ = 0;
  ratios_.clear();
  for (std::size_t i = 0; i < moved_.size(); ++i)
    if (expected_[i] > 0) ratios_.push_back(moved_[i].squaredNorm() / expected_[i]);
  std::ranges::fill(moved_, Vec3(Vec3::Zero()));
  std::ranges::fill(expected_, 0.0);
  if (ratios_.size() < kLeastSensors) return 1;
  std::ranges::sort(ratios_);
  const double ratio =
      std::clamp(quantile_of_sorted(ratios_, 0.5) / usual_ratio_, 1 / kMostOfOne, kMostOfOne);
  const double before = factor_;
  factor_ = std::clamp(factor_ * ratio, 1.0, kMostFactor);
  return factor_ / before;
}

}  // namespace mien::imu
