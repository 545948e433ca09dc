#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// What a simulated headset with cameras is like, what is wrong with it, and who wears it, as a headset rig's
/// [faults] table states it (docs/method/headset.md gives the reasons): one sigma unless said otherwise,
/// pairs are the least and the most, uniform. The defaults are a perfect headset on a plain face.
struct HeadsetFaults {
  // Who wears it.
  double skin_gain = 0;  ///< Relative, of all skin at 850 nm between people.
  double pores = 0;      ///< Relative depth of the skin's grain.
  double make_up = 0;    ///< Shares of wearers, 0 to 1, from here ...
  double stubble = 0;
  double beard = 0;
  double moustache = 0;
  double spectacles = 0;                 ///< ... to here.
  std::array<double, 2> pupil_mm{4, 4};  ///< Diameter, a wearer's mean.
  double pupil_breath = 0;               ///< Relative, slow.

  // The headset as it was glued.
  double camera_mm = 0;   ///< Of a camera's place, each axis, ...
  double camera_deg = 0;  ///< ... and of where it looks.
  double field_of_view_deg = 0;
  double radial_k1 = 0;
  double centre = 0;                   ///< Of the axis in the picture, share of its width.
  double lamp_gain = 0;                ///< Relative, between lamps.
  double lamp_dead = 0;                ///< Share of lamps, 0 to 1.
  std::array<double, 2> ambient{};     ///< Light from outside, share of what the lamps give.
  std::array<double, 2> background{};  ///< Of the headset's inside, share of what white skin sends.

  // The lens.
  std::array<double, 2> aperture_mm{0.1, 0.1};  ///< Diameter.
  std::array<double, 2> focus_mm{50, 50};
  std::array<double, 2> blur_px{};     ///< Gaussian, pixels of a picture 240 wide.
  std::array<double, 2> vignetting{};  ///< Loss in the corners beyond the cosine's fourth power, 0 to 1.
  std::array<double, 2> smear{};       ///< Share of the light that grease spreads, 0 to 1.

  // The sensor.
  std::array<double, 2> target{0.45,
                               0.45};  ///< The brightest tenth is shown from here on, share of full scale.
  double exposure_s = 0.25;            ///< Time constant of that control.
  double full_well = 1e6;              ///< Electrons at full scale.
  double read_noise = 0;               ///< Of 255.
  std::array<double, 2> gamma{1, 1};   ///< What comes out is light to this power.
  double hot_pixels = 0;               ///< Share of pixels, 0 to 1.
  double rolling_ms = 0;               ///< From the first row's exposure to the last one's.
  std::array<double, 2> jpeg_quality{7, 7};  ///< As camera boards count, 4 to 63: lower is better.

  // How it sits.
  double seat_mm = 0;  ///< Drawn at each donning, each axis.
  double seat_deg = 0;
  double slip_mm_per_sqrt_min = 0;  ///< Random walk while worn, each axis.
  double slip_deg_per_sqrt_min = 0;
  double lift_mm = 0;  ///< Fully raised cheeks lift it by this, and tip it back by lift_deg.
  double lift_deg = 0;
  double sway_mm = 0;  ///< Unrest while face and head move, each axis, ...
  double sway_deg = 0;
  double sway_s = 1;  ///< ... and how long one lasts (time constant).

  // The board.
  std::array<double, 2> clock_offset_s{};
  double clock_drift_ppm = 0;
  double period_jitter_ms = 0;  ///< Of a picture's begin.
  double lost = 0;              ///< Share of pictures that never come, 0 to 1.

  bool operator==(const HeadsetFaults&) const = default;
};

/// Errors: malformed TOML, unknown keys; out_of_range: a number that is not finite, negative, or that no
/// lens, sensor or share has. `where` names the source in messages.
[[nodiscard]] Result<HeadsetFaults> parse_headset_faults(std::string_view toml, const std::string& where);

}  // namespace mien::virt
