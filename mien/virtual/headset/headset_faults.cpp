#include "mien/virtual/headset/headset_faults.h"

#include "mien/virtual/fault_table.h"

namespace mien::virt {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HeadsetFaults, skin_gain, pores, make_up, stubble, beard, moustache,
                                   spectacles, pupil_mm, pupil_breath, camera_mm, camera_deg,
                                   field_of_view_deg, radial_k1, centre, lamp_gain, lamp_dead, ambient,
                                   background, aperture_mm, focus_mm, blur_px, vignetting, smear, target,
                                   exposure_s, full_well, read_noise, gamma, hot_pixels, rolling_ms,
                                   jpeg_quality, seat_mm, seat_deg, slip_mm_per_sqrt_min,
                                   slip_deg_per_sqrt_min, lift_mm, lift_deg, sway_mm, sway_deg, sway_s,
                                   clock_offset_s, clock_drift_ppm, period_jitter_ms, lost)

Result<HeadsetFaults> parse_headset_faults(std::string_view text, const std::string& where) {
  static constexpr FaultLimit kLimits[] = {{"skin_gain", 0, 0.5},
                                           {"pores", 0, 0.5},
                                           {"make_up", 0, 1},
                                           {"stubble", 0, 1},
                                           {"beard", 0, 1},
                                           {"moustache", 0, 1},
                                           {"spectacles", 0, 1},
                                           {"pupil_mm", 1, 9},
                                           {"pupil_breath", 0, 0.3},
                                           {"camera_mm", 0, 10},
                                           {"camera_deg", 0, 20},
                                           {"field_of_view_deg", 0, 10},
                                           {"radial_k1", 0, 0.1},
                                           {"centre", 0, 0.2},
                                           {"lamp_gain", 0, 1},
                                           {"lamp_dead", 0, 0.5},
                                           {"ambient", 0, 10},
                                           {"background", 0, 10},
                                           {"aperture_mm", 0, 5},
                                           {"focus_mm", 5, 1e6},
                                           {"blur_px", 0, 10},
                                           {"vignetting", 0, 1},
                                           {"smear", 0, 1},
                                           {"target", 0.01, 0.95},
                                           {"exposure_s", 1e-3, 1e3},
                                           {"full_well", 10, 1e6},
                                           {"read_noise", 0, 100},
                                           {"gamma", 0.2, 5},
                                           {"hot_pixels", 0, 0.1},
                                           {"rolling_ms", 0, 100},
                                           {"jpeg_quality", 4, 63},
                                           {"seat_mm", 0, 15},
                                           {"seat_deg", 0, 20},
                                           {"lift_mm", 0, 10},
                                           {"lift_deg", 0, 10},
                                           {"sway_s", 1e-3, 1e6},
                                           {"clock_drift_ppm", 0, 1e4},
                                           {"period_jitter_ms", 0, 20},
                                           {"lost", 0, 1}};
  MIEN_TRY_ASSIGN(const HeadsetFaults faults, parse_fault_table<HeadsetFaults>(text, where, kLimits));
  if (faults.focus_mm[0] > 1e4)
    return fail(ErrorCode::out_of_range, "focus_mm must begin at 5 to 10000", where);
  return faults;
}

}  // namespace mien::virt
