#include "mien/virtual/eyewear/eyewear_faults.h"

#include <cmath>

#include "mien/virtual/fault_table.h"

namespace mien::virt {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(EyewearFaults, focal_peak_mm, falloff_mm, cone_deg, white_at_peak,
                                   part_gain, pair_rate_hz, adc_bits, noise_counts, skin_reflectance, pattern,
                                   pattern_mm, blush_per_sqrt_min, sweat_per_sqrt_min, ambient,
                                   ambient_flicker, ambient_walk_per_sqrt_min, strobe_hz, strobe_ms, strobe,
                                   fit_mm, mount_shift_mm, mount_tilt_deg, slip_mm_per_sqrt_min,
                                   slip_deg_per_sqrt_min, sway_mm, sway_deg, sway_s, tissue_mm, tissue_s,
                                   ride_up_mm, marker_jitter_mm, mislabel_per_min, mislabel_s, lost_per_min,
                                   lost_s, lost_mm, clock_offset_s, clock_drift_ppm)

Result<EyewearFaults> parse_eyewear_faults(std::string_view text, const std::string& where) {
  static constexpr FaultLimit kLimits[] = {
      {"focal_peak_mm", 0.1, 100},   {"falloff_mm", 0.1, 100},   {"cone_deg", 0, 60},
      {"pair_rate_hz", 1, 10000},    {"adc_bits", 1, 24},        {"part_gain", 0, 0.3},
      {"skin_reflectance", 0.01, 1}, {"pattern", 0, 0.3},        {"pattern_mm", 0.5, 1000},
      {"ambient_flicker", 0, 1},     {"fit_mm", 0.1, 1e6},       {"sway_s", 1e-3, 1e6},
      {"tissue_mm", 0, 20},          {"tissue_s", 1e-3, 1e6},    {"mount_shift_mm", 0, 30},
      {"mount_tilt_deg", 0, 45},     {"clock_drift_ppm", 0, 1e4}};
  MIEN_TRY_ASSIGN(const EyewearFaults faults, parse_fault_table<EyewearFaults>(text, where, kLimits));
  if (faults.fit_mm[0] > 100) return fail(ErrorCode::out_of_range, "fit_mm must begin at 0.1 to 100", where);
  if (faults.adc_bits != std::floor(faults.adc_bits))
    return fail(ErrorCode::out_of_range, "adc_bits must be a whole number", where);
  return faults;
}

}  // namespace mien::virt
