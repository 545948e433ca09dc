#include "mien/session/drift_watch.h"

#include <cmath>

namespace mien::session {

std::optional<DriftWatch::Advice> DriftWatch::add(
    DeviceTime frame, std::span<const std::optional<tracker::SensorCertainty>> sensors) {
  double square = 0, known = 0;
  bool left_out = false;
  for (const std::optional<tracker::SensorCertainty>& one : sensors) {
    if (!one) continue;
    square += one->sigma_rad * one->sigma_rad;
    ++known;
    left_out = left_out || one->left_out;
  }
  sigma_rad_.reset();
  if (known > 0) sigma_rad_ = std::sqrt(square / known);
  if (!left_out && sigma_rad_.value_or(0) <= kLimit_rad) {
    since_.reset();
    advises_ = false;
    return std::nullopt;
  }
  if (!since_) since_ = frame;
  advises_ = frame - *since_ >= kFor;
  if (!advises_ || (told_ && frame - *told_ < kAgain)) return std::nullopt;
  told_ = frame;
  Advice advice{.sigma_rad = *sigma_rad_, .left_out = {}};
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (sensors[i] && sensors[i]->left_out) advice.left_out.push_back(static_cast<std::uint16_t>(i));
  return advice;
}

void DriftWatch::reset() {
  since_.reset();
  told_.reset();
  advises_ = false;
}

}  // namespace mien::session
