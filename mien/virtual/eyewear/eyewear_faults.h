#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// What simulated photo-reflective eyewear is like and what is wrong with it, as an eyewear rig's [faults]
/// table states it (docs/method/eyewear.md gives the reasons): one sigma unless said otherwise. The defaults
/// are a perfect device in the dark, on even skin, seen by perfect motion capture.
struct EyewearFaults {
  // The part.
  double focal_peak_mm = 3;   ///< Where most light comes back.
  double falloff_mm = 2;      ///< b of 1 / (d + b)^2 beyond the peak.
  double cone_deg = 0;        ///< Half-angle of the cone that the LED lights.
  double white_at_peak = 1;   ///< Light of a white surface at the peak, share of full scale.
  double part_gain = 0;       ///< Relative spread between parts of a kind.
  double pair_rate_hz = 230;  ///< On-off pairs a second of each sensor.
  double adc_bits = 10;       ///< 1 to 24, whole.
  double noise_counts = 0;    ///< Of a reading, in steps of ten bits.

  // The skin.
  std::array<double, 2> skin_reflectance{0.55, 0.55};  ///< Of a person, in the near infrared, uniform.
  double pattern = 0;                                  ///< Relative: spots, hair, pores; fixed to the skin.
  double pattern_mm = 6;                               ///< Their size.
  double blush_per_sqrt_min = 0;                       ///< Relative random walk of all skin: blood flow.
  double sweat_per_sqrt_min = 0;                       ///< The same of each sensor's spot.

  // Other light.
  std::array<double, 2> ambient{};  ///< At a sensor, share of full scale, uniform.
  double ambient_flicker = 0;       ///< Relative depth at 100 Hz.
  double ambient_walk_per_sqrt_min = 0;
  double strobe_hz = 0;  ///< Of the motion capture's lamps; 0: none.
  double strobe_ms = 0;
  std::array<double, 2> strobe{};  ///< At a sensor while they flash, share of full scale, uniform.

  // How they sit.
  std::array<double, 2> fit_mm{4, 16};  ///< A sensor nearer or farther than this at neutral is bent to it.
  double mount_shift_mm = 0;            ///< Each time they are put on: up to this, any direction, ...
  double mount_tilt_deg = 0;            ///< ... and up to this about any axis.
  double slip_mm_per_sqrt_min = 0;      ///< Random walk of each axis while worn.
  double slip_deg_per_sqrt_min = 0;
  double sway_mm =
      0;  ///< The frame's unrest while the face and head move, each axis, about where it sits, ...
  double sway_deg = 0;
  double sway_s = 1;  ///< ... and how long a sway lasts (time constant).
  double tissue_mm =
      0;  ///< Folds and bulges of the skin that no marker and no shape tells of, at each spot, ...
  double tissue_s = 1;    ///< ... and how long one lasts.
  double ride_up_mm = 0;  ///< How far fully raised cheeks or a fully wrinkled nose lift the frame, each.

  // Motion capture of the markers.
  double marker_jitter_mm = 0;
  double mislabel_per_min = 0;  ///< Times a minute that two neighbouring markers change names, ...
  double mislabel_s = 0;        ///< ... for this long on average.
  double lost_per_min = 0;      ///< Times a minute that a covered marker is found elsewhere, ...
  double lost_s = 0;            ///< ... for this long on average, ...
  double lost_mm = 0;           ///< ... this far away, one sigma an axis.

  // Its clock.
  std::array<double, 2> clock_offset_s{};
  double clock_drift_ppm = 0;

  bool operator==(const EyewearFaults&) const = default;
};

/// Errors: malformed TOML, unknown keys; out_of_range: a number that is not finite, negative or above 1e6, a
/// rate, bits or size that no part has. `where` names the source in messages.
[[nodiscard]] Result<EyewearFaults> parse_eyewear_faults(std::string_view toml, const std::string& where);

}  // namespace mien::virt
