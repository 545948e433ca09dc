#include "mien/imu/walk_scale.h"

#include <algorithm>

namespace mien::imu {
namespace {

/// The median ratio of corrections to expectation that is usual; it is below one, since the filter takes more
/// of the skin's motion for correlated than is. Virtual performers of seeds 101 to 104 with the rig's faults,
/// means of ten minutes: creep 0.28 to 0.54, headings' rates 0.10 to 0.33.
constexpr double kUsualRatio = 0.5;
/// One window's ratio counts for so much at most.
constexpr double kMostOfOne = 5;
/// Four times the expected walk. Below 1 the factor never goes: a wearer who holds still would lower it.
constexpr double kMostFactor = 16;

}  // namespace

WalkScale::WalkScale(std::size_t sensors, double window_s)
    : window_s_(window_s), moved_(sensors, Vec3::Zero()), expected_(sensors) {
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
  if (ratios_.empty()) return 1;
  const auto middle = ratios_.begin() + static_cast<std::ptrdiff_t>(ratios_.size() / 2);
  std::ranges::nth_element(ratios_, middle);
  const double before = factor_;
  factor_ =
      std::clamp(factor_ * std::clamp(*middle / kUsualRatio, 1 / kMostOfOne, kMostOfOne), 1.0, kMostFactor);
  return factor_ / before;
}

}  // namespace mien::imu
