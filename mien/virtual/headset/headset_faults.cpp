#include "mien/virtual/headset/headset_faults.h"

#include <fmt/format.h>

#include "mien/virtual/fault_table.h"

namespace mien::virt {
namespace {

/// What a magnitude may be at most; all begin at `least`.
struct Limit {
  std::string_view key;
  double value = 0, least = 0, most = 0;
};

}  // namespace

Result<HeadsetFaults> parse_headset_faults(std::string_view text, const std::string& where) {
  HeadsetFaults f;
  const FaultTable table{{{"skin_gain", &f.skin_gain},
                          {"pores", &f.pores},
                          {"make_up", &f.make_up},
                          {"stubble", &f.stubble},
                          {"beard", &f.beard},
                          {"moustache", &f.moustache},
                          {"spectacles", &f.spectacles},
                          {"pupil_breath", &f.pupil_breath},
                          {"camera_mm", &f.camera_mm},
                          {"camera_deg", &f.camera_deg},
                          {"field_of_view_deg", &f.field_of_view_deg},
                          {"radial_k1", &f.radial_k1},
                          {"centre", &f.centre},
                          {"lamp_gain", &f.lamp_gain},
                          {"lamp_dead", &f.lamp_dead},
                          {"exposure_s", &f.exposure_s},
                          {"full_well", &f.full_well},
                          {"read_noise", &f.read_noise},
                          {"hot_pixels", &f.hot_pixels},
                          {"rolling_ms", &f.rolling_ms},
                          {"seat_mm", &f.seat_mm},
                          {"seat_deg", &f.seat_deg},
                          {"slip_mm_per_sqrt_min", &f.slip_mm_per_sqrt_min},
                          {"slip_deg_per_sqrt_min", &f.slip_deg_per_sqrt_min},
                          {"lift_mm", &f.lift_mm},
                          {"lift_deg", &f.lift_deg},
                          {"sway_mm", &f.sway_mm},
                          {"sway_deg", &f.sway_deg},
                          {"sway_s", &f.sway_s},
                          {"clock_drift_ppm", &f.clock_drift_ppm},
                          {"period_jitter_ms", &f.period_jitter_ms},
                          {"lost", &f.lost}},
                         {{"pupil_mm", &f.pupil_mm},
                          {"ambient", &f.ambient},
                          {"background", &f.background},
                          {"aperture_mm", &f.aperture_mm},
                          {"focus_mm", &f.focus_mm},
                          {"blur_px", &f.blur_px},
                          {"vignetting", &f.vignetting},
                          {"smear", &f.smear},
                          {"target", &f.target},
                          {"gamma", &f.gamma},
                          {"jpeg_quality", &f.jpeg_quality},
                          {"clock_offset_s", &f.clock_offset_s}},
                         {}};
  MIEN_TRY(table.read(text, where));
  for (const Limit& limit : {Limit{"skin_gain", f.skin_gain, 0, 0.5},
                             Limit{"pores", f.pores, 0, 0.5},
                             Limit{"make_up", f.make_up, 0, 1},
                             Limit{"stubble", f.stubble, 0, 1},
                             Limit{"beard", f.beard, 0, 1},
                             Limit{"moustache", f.moustache, 0, 1},
                             Limit{"spectacles", f.spectacles, 0, 1},
                             Limit{"pupil_mm", f.pupil_mm[0], 1, 9},
                             Limit{"pupil_mm", f.pupil_mm[1], 1, 9},
                             Limit{"pupil_breath", f.pupil_breath, 0, 0.3},
                             Limit{"camera_mm", f.camera_mm, 0, 10},
                             Limit{"camera_deg", f.camera_deg, 0, 20},
                             Limit{"field_of_view_deg", f.field_of_view_deg, 0, 10},
                             Limit{"radial_k1", f.radial_k1, 0, 0.1},
                             Limit{"centre", f.centre, 0, 0.2},
                             Limit{"lamp_gain", f.lamp_gain, 0, 1},
                             Limit{"lamp_dead", f.lamp_dead, 0, 0.5},
                             Limit{"ambient", f.ambient[1], 0, 10},
                             Limit{"background", f.background[1], 0, 10},
                             Limit{"aperture_mm", f.aperture_mm[1], 0, 5},
                             Limit{"focus_mm", f.focus_mm[0], 5, 1e4},
                             Limit{"blur_px", f.blur_px[1], 0, 10},
                             Limit{"vignetting", f.vignetting[1], 0, 1},
                             Limit{"smear", f.smear[1], 0, 1},
                             Limit{"target", f.target[0], 0.01, 0.95},
                             Limit{"target", f.target[1], 0.01, 0.95},
                             Limit{"exposure_s", f.exposure_s, 1e-3, 1e3},
                             Limit{"full_well", f.full_well, 10, 1e6},
                             Limit{"read_noise", f.read_noise, 0, 100},
                             Limit{"gamma", f.gamma[0], 0.2, 5},
                             Limit{"gamma", f.gamma[1], 0.2, 5},
                             Limit{"hot_pixels", f.hot_pixels, 0, 0.1},
                             Limit{"rolling_ms", f.rolling_ms, 0, 100},
                             Limit{"jpeg_quality", f.jpeg_quality[0], 4, 63},
                             Limit{"jpeg_quality", f.jpeg_quality[1], 4, 63},
                             Limit{"seat_mm", f.seat_mm, 0, 15},
                             Limit{"seat_deg", f.seat_deg, 0, 20},
                             Limit{"lift_mm", f.lift_mm, 0, 10},
                             Limit{"lift_deg", f.lift_deg, 0, 10},
                             Limit{"sway_s", f.sway_s, 1e-3, 1e6},
                             Limit{"clock_drift_ppm", f.clock_drift_ppm, 0, 1e4},
                             Limit{"period_jitter_ms", f.period_jitter_ms, 0, 20},
                             Limit{"lost", f.lost, 0, 1}})
    if (limit.value < limit.least || limit.value > limit.most)
      return fail(ErrorCode::out_of_range,
                  fmt::format("{} must be {:g} to {:g}", limit.key, limit.least, limit.most), where);
  return f;
}

}  // namespace mien::virt
