#include "mien/tracker/worn_anew.h"

#include <cmath>

#include "mien/core/rotation.h"
#include "mien/core/time.h"
#include "mien/core/units.h"

namespace mien::tracker {
namespace {

Vec3 drawn(Random& random, double sigma_deg) {
  const double sigma_rad = sigma_deg / kDegPerRad;
  const double x = random.normal(0, sigma_rad), y = random.normal(0, sigma_rad),
               z = random.normal(0, sigma_rad);
  return {x, y, z};
}

}  // namespace

WornAnew::WornAnew(std::size_t sensors, const WearingSpread& spread, const Random& random)
    : keep_(std::exp(-1 / (spread.heading_s * kFrameRateHz))),
      step_rad_(spread.heading_deg / kDegPerRad * std::sqrt(1 - keep_ * keep_)),
      walk_(random.fork("heading")) {
  Random frame_stream = random.fork("frame");
  const Quat frame = exp_rotation(drawn(frame_stream, spread.frame_deg));
  for (std::size_t s = 0; s < sensors; ++s) {
    Random stream = random.fork("sensor", s);
    Sensor& sensor = sensors_.emplace_back();
    sensor.axes = frame * exp_rotation(drawn(stream, spread.axes_deg));
    sensor.gain = std::exp(stream.normal(0, spread.gain));
    sensor.offset = exp_rotation(drawn(stream, spread.offset_deg));
    sensor.heading_rad = stream.normal(0, spread.heading_deg / kDegPerRad);
  }
}

void WornAnew::apply(model::FeatureFrame& frame) {
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    Sensor& sensor = sensors_[s];
    sensor.heading_rad = keep_ * sensor.heading_rad + walk_.normal(0, step_rad_);
    model::SensorFeature& feature = frame.sensors[s];
    if (feature.has_accel)
      feature.accel_m_s2 = (sensor.axes * feature.accel_m_s2.cast<double>()).cast<float>();
    if (!feature.has_rotation) continue;
    const Vec3 turned = sensor.axes * (sensor.gain * log_rotation(quat_of(feature.rotation)));
    feature.rotation = wxyz_of(
        canonical(exp_rotation(Vec3(0, sensor.heading_rad, 0)) * sensor.offset * exp_rotation(turned)));
  }
}

}  // namespace mien::tracker
