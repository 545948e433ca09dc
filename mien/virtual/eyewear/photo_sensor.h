#pragma once

#include "mien/core/random.h"
#include "mien/virtual/eyewear/eyewear_faults.h"

namespace mien::virt {

/// How much light a photo-reflective part gets back from a surface at a distance: LED and transistor stand
/// side by side, so that close up their fields do not meet; then comes a peak; beyond it the light falls as
/// 1 / (d + b)^2. f(d) = (1 - exp(-(d/p)^2)) / (d + b)^2, p such that the peak is where it is asked for.
class PhotoResponse {
 public:
  /// Metres, both above 0.
  PhotoResponse(double peak_m, double falloff_m);

  /// 1 at the peak; 0 at contact. Distances below 0 are contact.
  [[nodiscard]] double at(double distance_m) const;

 private:
  double peak_m_;
  double falloff_m_;
  double near_m_ = 1;  ///< p.
  double scale_ = 1;
};

/// What a part says of the light that falls on it, as its board converts it: its own amplification, other
/// light, noise, the steps of the converter, and its ends.
class PhotoSensor {
 public:
  /// Draws the part and where it stands to lamps.
  PhotoSensor(const EyewearFaults& faults, Random random);

  /// One reading at `time_s`, as a share of full scale in steps of the converter, 0 to 1. `reflected`: what
  /// comes back of the LED's light, as a white surface at the peak gives 1; 0 with the LED off.
  [[nodiscard]] double read(double reflected, double time_s);
  /// Other light drifts for `seconds`.
  void wait(double seconds);
  /// Light that comes back as a bench in the dark has it after averaging: no noise, no steps, no ends.
  [[nodiscard]] double bench(double reflected) const;

 private:
  EyewearFaults faults_;
  double gain_ = 1;
  double ambient_ = 0;
  double ambient_drift_ = 0;
  double flicker_phase_ = 0;  ///< Turns.
  double strobe_ = 0;
  double strobe_phase_ = 0;  ///< Turns; drawn a sensor, since exposure and cables differ.
  Random noise_;
  Random drift_;
};

}  // namespace mien::virt
