#include "mien/virtual/eyewear/eyewear_faults.h"

#include <fmt/format.h>

#include <cmath>

#include "mien/virtual/fault_table.h"

namespace mien::virt {
Result<EyewearFaults> parse_eyewear_faults(std::string_view text, const std::string& where) {
  EyewearFaults faults;
  const std::map<std::string_view, double*> numbers = {
      {"focal_peak_mm", &faults.focal_peak_mm},
      {"falloff_mm", &faults.falloff_mm},
      {"cone_deg", &faults.cone_deg},
      {"white_at_peak", &faults.white_at_peak},
      {"part_gain", &faults.part_gain},
      {"pair_rate_hz", &faults.pair_rate_hz},
      {"adc_bits", &faults.adc_bits},
      {"noise_counts", &faults.noise_counts},
      {"pattern", &faults.pattern},
      {"pattern_mm", &faults.pattern_mm},
      {"blush_per_sqrt_min", &faults.blush_per_sqrt_min},
      {"sweat_per_sqrt_min", &faults.sweat_per_sqrt_min},
      {"ambient_flicker", &faults.ambient_flicker},
      {"ambient_walk_per_sqrt_min", &faults.ambient_walk_per_sqrt_min},
      {"strobe_hz", &faults.strobe_hz},
      {"strobe_ms", &faults.strobe_ms},
      {"mount_shift_mm", &faults.mount_shift_mm},
      {"mount_tilt_deg", &faults.mount_tilt_deg},
      {"slip_mm_per_sqrt_min", &faults.slip_mm_per_sqrt_min},
      {"slip_deg_per_sqrt_min", &faults.slip_deg_per_sqrt_min},
      {"sway_mm", &faults.sway_mm},
      {"sway_deg", &faults.sway_deg},
      {"sway_s", &faults.sway_s},
      {"tissue_mm", &faults.tissue_mm},
      {"tissue_s", &faults.tissue_s},
      {"ride_up_mm", &faults.ride_up_mm},
      {"marker_jitter_mm", &faults.marker_jitter_mm},
      {"mislabel_per_min", &faults.mislabel_per_min},
      {"mislabel_s", &faults.mislabel_s},
      {"lost_per_min", &faults.lost_per_min},
      {"lost_s", &faults.lost_s},
      {"lost_mm", &faults.lost_mm},
      {"clock_drift_ppm", &faults.clock_drift_ppm},
  };
  const std::map<std::string_view, std::array<double, 2>*> ranges = {
      {"skin_reflectance", &faults.skin_reflectance},
      {"ambient", &faults.ambient},
      {"strobe", &faults.strobe},
      {"fit_mm", &faults.fit_mm},
      {"clock_offset_s", &faults.clock_offset_s},
  };
  const FaultTable table{numbers, ranges, {}};
  MIEN_TRY(table.read(text, where));
  MIEN_TRY(check_limits({{"focal_peak_mm", faults.focal_peak_mm, 0.1, 100},
                         {"falloff_mm", faults.falloff_mm, 0.1, 100},
                         {"cone_deg", faults.cone_deg, 0, 60},
                         {"pair_rate_hz", faults.pair_rate_hz, 1, 10000},
                         {"adc_bits", faults.adc_bits, 1, 24},
                         {"part_gain", faults.part_gain, 0, 0.3},
                         {"skin_reflectance", faults.skin_reflectance[0], 0.01, 1},
                         {"skin_reflectance", faults.skin_reflectance[1], 0.01, 1},
                         {"pattern", faults.pattern, 0, 0.3},
                         {"pattern_mm", faults.pattern_mm, 0.5, 1000},
                         {"ambient_flicker", faults.ambient_flicker, 0, 1},
                         {"fit_mm", faults.fit_mm[0], 0.1, 100},
                         {"sway_s", faults.sway_s, 1e-3, 1e6},
                         {"tissue_mm", faults.tissue_mm, 0, 20},
                         {"tissue_s", faults.tissue_s, 1e-3, 1e6},
                         {"mount_shift_mm", faults.mount_shift_mm, 0, 30},
                         {"mount_tilt_deg", faults.mount_tilt_deg, 0, 45},
                         {"clock_drift_ppm", faults.clock_drift_ppm, 0, 1e4}},
                        where));
  if (faults.adc_bits != std::floor(faults.adc_bits))
    return fail(ErrorCode::out_of_range, "adc_bits must be a whole number", where);
  return faults;
}

}  // namespace mien::virt
