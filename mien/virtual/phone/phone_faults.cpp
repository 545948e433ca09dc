#include "mien/virtual/phone/phone_faults.h"

#include "mien/virtual/fault_table.h"

namespace mien::virt {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PhoneFaults, rate_hz, counts_sixtieths, clock_offset_s, clock_drift_ppm,
                                   lag_ms, smoothing_ms, delay_ms, frames_dropped, face_loss_per_hour,
                                   face_loss_s, face_lost_between_s, resting_offset, gain_error, noise,
                                   noise_time_s)

PhoneFaults usual_phone() {
  PhoneFaults faults;
  faults.clock_offset_s = {1'000, 100'000};
  faults.clock_drift_ppm = 10;
  faults.lag_ms = {17, 33};
  faults.smoothing_ms = 15;
  faults.delay_ms = {60, 120};
  faults.frames_dropped = 0.03;
  faults.face_loss_per_hour = 6;
  faults.resting_offset = 0.04;
  faults.gain_error = 0.1;
  faults.noise = 0.01;
  return faults;
}

Result<PhoneFaults> parse_phone_faults(std::string_view text, const std::string& where) {
  static constexpr FaultLimit kLimits[] = {{"clock_drift_ppm", 0, 1e4}, {"lag_ms", 0, 2'000},
                                           {"smoothing_ms", 0, 2'000},  {"delay_ms", 0, 2'000},
                                           {"frames_dropped", 0, 1},    {"resting_offset", 0, 1},
                                           {"gain_error", 0, 1},        {"noise", 0, 1}};
  MIEN_TRY_ASSIGN(const PhoneFaults faults, parse_fault_table<PhoneFaults>(text, where, kLimits));
  if (faults.rate_hz != 60 && faults.rate_hz != 30)
    return fail(ErrorCode::out_of_range, "rate_hz must be 60 or 30", where);
  return faults;
}

}  // namespace mien::virt
