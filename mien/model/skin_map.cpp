#include "mien/model/skin_map.h"

#include <algorithm>

#include "mien/core/rotation.h"

namespace mien::model {
namespace {

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// What a rotation's noise leaves after the network's own memory has averaged it, rad an axis.
constexpr double kNoiseRad = 0.0096;
/// Slopes are linear and known to a tenth: that share of what a sensor usually says is unsure.
constexpr double kSlopeError = 0.1;
/// A sensor that is missing, rad^2.
constexpr double kUnheard = 1e9;

}  // namespace

SkinMap::SkinMap(const Skin& skin, std::span<const float> mean)
    : sensors_(static_cast<Eigen::Index>(skin.wearer.size() / mean.size() / 3)),
      masked_for_(static_cast<std::size_t>(sensors_), 0) {
  const Eigen::Index rows = 3 * sensors_, shapes = static_cast<Eigen::Index>(mean.size());
  const Eigen::MatrixXd standard =
      Eigen::Map<const RowMajor>(skin.standard.data(), rows, shapes).cast<double>();
  const Eigen::MatrixXd wearer = Eigen::Map<const RowMajor>(skin.wearer.data(), rows, shapes).cast<double>();
  const Eigen::MatrixXd covariance =
      Eigen::Map<const RowMajor>(skin.covariance.data(), shapes, shapes).cast<double>();
  const Eigen::VectorXd middle = Eigen::Map<const Eigen::VectorXf>(mean.data(), shapes).cast<double>();
  spread_ = wearer * covariance * wearer.transpose();
  rest_ = wearer * middle;
  const Eigen::ArrayXd usual = spread_.diagonal().array() + rest_.array().square();
  spread_.diagonal().array() += kNoiseRad * kNoiseRad + kSlopeError * kSlopeError * usual;
  moved_ = (standard - wearer) * covariance * wearer.transpose();
  shift_ = (standard - wearer) * middle;
  masked_ = spread_;
  factor_ = Eigen::LLT<Eigen::MatrixXd>(rows);
  factor_.compute(masked_);
  std::ranges::fill(masked_for_, std::uint8_t{1});
  turn_.setZero(rows);
  innovation_.setZero(rows);
}

void SkinMap::listen_to(std::span<const std::uint8_t> present) {
  if (std::ranges::equal(present, masked_for_)) return;
  std::ranges::copy(present, masked_for_.begin());
  masked_ = spread_;
  for (Eigen::Index s = 0; s < sensors_; ++s)
    if (present[static_cast<std::size_t>(s)] == 0) masked_.diagonal().segment<3>(3 * s).array() += kUnheard;
  factor_.compute(masked_);
}

void SkinMap::apply(std::span<float> values, std::span<const std::uint8_t> present) {
  const auto n = static_cast<std::size_t>(sensors_);
  listen_to(present.first(n));
  const auto rotation = [&](std::size_t s) { return values.subspan(7 * s + 3, 4); };
  for (std::size_t s = 0; s < n; ++s) {
    const auto at = 3 * static_cast<Eigen::Index>(s);
    const std::span<const float> q = rotation(s);
    turn_.segment<3>(at) =
        present[s] != 0 ? log_rotation(Quat(q[0], q[1], q[2], q[3])) : Vec3(rest_.segment<3>(at));
  }
  innovation_ = turn_ - rest_;
  factor_.solveInPlace(innovation_);
  turn_ += shift_;
  turn_.noalias() += moved_ * innovation_;
  for (std::size_t s = 0; s < n; ++s) {
    if (present[s] == 0) continue;
    const Quat q = canonical(exp_rotation(Vec3(turn_.segment<3>(3 * static_cast<Eigen::Index>(s)))));
    const std::span<float> out = rotation(s);
    out[0] = static_cast<float>(q.w());
    out[1] = static_cast<float>(q.x());
    out[2] = static_cast<float>(q.y());
    out[3] = static_cast<float>(q.z());
  }
}

}  // namespace mien::model
