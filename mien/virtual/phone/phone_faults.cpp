#include "mien/virtual/phone/phone_faults.h"

#include "mien/virtual/fault_table.h"

namespace mien::virt {
namespace {

constexpr double kMostPhoneDriftPpm = 1e4;  // A hundredth, as of other devices.
constexpr double kLatestPhoneMs = 2'000;

}  // namespace

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
  PhoneFaults faults;
  const FaultTable table{{{"rate_hz", &faults.rate_hz},
                          {"clock_drift_ppm", &faults.clock_drift_ppm},
                          {"smoothing_ms", &faults.smoothing_ms},
                          {"frames_dropped", &faults.frames_dropped},
                          {"face_loss_per_hour", &faults.face_loss_per_hour},
                          {"resting_offset", &faults.resting_offset},
                          {"gain_error", &faults.gain_error},
                          {"noise", &faults.noise},
                          {"noise_time_s", &faults.noise_time_s}},
                         {{"clock_offset_s", &faults.clock_offset_s},
                          {"lag_ms", &faults.lag_ms},
                          {"delay_ms", &faults.delay_ms},
                          {"face_loss_s", &faults.face_loss_s},
                          {"face_lost_between_s", &faults.face_lost_between_s}},
                         {{"counts_sixtieths", &faults.counts_sixtieths}}};
  MIEN_TRY(table.read(text, where));
  if (faults.rate_hz != 60 && faults.rate_hz != 30)
    return fail(ErrorCode::out_of_range, "rate_hz must be 60 or 30", where);
  MIEN_TRY(check_limits({{"clock_drift_ppm", faults.clock_drift_ppm, 0, kMostPhoneDriftPpm},
                         {"lag_ms", faults.lag_ms[1], 0, kLatestPhoneMs},
                         {"smoothing_ms", faults.smoothing_ms, 0, kLatestPhoneMs},
                         {"delay_ms", faults.delay_ms[1], 0, kLatestPhoneMs},
                         {"frames_dropped", faults.frames_dropped, 0, 1},
                         {"resting_offset", faults.resting_offset, 0, 1},
                         {"gain_error", faults.gain_error, 0, 1},
                         {"noise", faults.noise, 0, 1}},
                        where));
  return faults;
}

}  // namespace mien::virt
