#include "mien/virtual/eyewear/photo_sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::virt {
namespace {

constexpr double kLampHz = 100;  // Twice the mains'.
/// noise_counts are steps of this.
constexpr double kTenBits = 1023;

}  // namespace

PhotoResponse::PhotoResponse(double peak_m, double falloff_m) : peak_m_(peak_m), falloff_m_(falloff_m) {
  // At the peak the slopes of both factors' logarithms cancel: u / (e^u - 1) = peak / (peak + b), where
  // u = (peak / p)^2. The left side falls from 1 to 0.
  const double wanted = peak_m / (peak_m + falloff_m);
  double low = 1e-9;
  double high = 100;
  for (int i = 0; i < 100; ++i) {
    const double u = 0.5 * (low + high);
    (u / std::expm1(u) > wanted ? low : high) = u;
  }
  near_m_ = peak_m / std::sqrt(low);
  scale_ = 1 / at(peak_m);
}

double PhotoResponse::at(double distance_m) const {
  if (distance_m <= 0) return 0;
  const double near = -std::expm1(-(distance_m / near_m_) * (distance_m / near_m_));
  const double far = (peak_m_ + falloff_m_) / (distance_m + falloff_m_);
  return scale_ * near * far * far;
}

PhotoSensor::PhotoSensor(const EyewearFaults& faults, Random random)
    : faults_(faults), noise_(random.fork("noise")), drift_(random.fork("drift")) {
  Random part = random.fork("part");
  gain_ = faults.white_at_peak * part.log_normal(faults.part_gain);
  Random lamps = random.fork("lamps");
  ambient_ = lamps.uniform(faults.ambient[0], faults.ambient[1]);
  flicker_phase_ = lamps.uniform();
  strobe_ = lamps.uniform(faults.strobe[0], faults.strobe[1]);
  strobe_phase_ = lamps.uniform();
}

double PhotoSensor::read(double reflected, double time_s) {
  const double flicker =
      1 + faults_.ambient_flicker * std::sin(2 * std::numbers::pi * (kLampHz * time_s + flicker_phase_));
  double light = gain_ * reflected + ambient_ * std::max(0.0, 1 + ambient_drift_) * flicker;
  const double turns = faults_.strobe_hz * time_s + strobe_phase_;
  if (turns - std::floor(turns) < 1e-3 * faults_.strobe_ms * faults_.strobe_hz) light += strobe_;
  light += noise_.normal(0, faults_.noise_counts / kTenBits);
  const double steps = std::exp2(faults_.adc_bits) - 1;
  return std::clamp(std::round(light * steps) / steps, 0.0, 1.0);
}

void PhotoSensor::wait(double seconds) {
  ambient_drift_ +=
      drift_.normal(0, faults_.ambient_walk_per_sqrt_min * std::sqrt(std::max(0.0, seconds) / 60));
}

double PhotoSensor::bench(double reflected) const {
  return gain_ * reflected;
}

}  // namespace mien::virt
