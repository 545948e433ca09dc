#include "mien/virtual/speech/microphone_faults.h"

#include <fmt/format.h>

#include "mien/virtual/fault_table.h"

namespace mien::virt {
namespace {

constexpr double kMostMicrophoneDriftPpm = 1e4;  // A hundredth, as of other devices.

}  // namespace

Result<MicrophoneFaults> parse_microphone_faults(std::string_view text, const std::string& where) {
  MicrophoneFaults faults;
  const FaultTable table{{{"clock_drift_ppm", &faults.clock_drift_ppm},
                          {"radio_delay_min_ms", &faults.radio_delay_min_ms},
                          {"radio_delay_ms", &faults.radio_delay_ms},
                          {"packet_loss", &faults.packet_loss},
                          {"sensor_loss_per_hour", &faults.sensor_loss_per_hour},
                          {"level", &faults.level},
                          {"noise", &faults.noise},
                          {"offset", &faults.offset}},
                         {{"clock_offset_s", &faults.clock_offset_s}},
                         {}};
  MIEN_TRY(table.read(text, where));
  for (const auto& [name, value] : {std::pair{"packet_loss", faults.packet_loss},
                                    std::pair{"noise", faults.noise}, std::pair{"offset", faults.offset}})
    if (value > 1)
      return fail(ErrorCode::out_of_range, fmt::format("{} is a share between 0 and 1", name), where);
  if (faults.clock_drift_ppm > kMostMicrophoneDriftPpm)
    return fail(ErrorCode::out_of_range,
                fmt::format("clock_drift_ppm must be at most {:.0f}", kMostMicrophoneDriftPpm), where);
  return faults;
}

}  // namespace mien::virt
