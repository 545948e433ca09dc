#include "mien/virtual/speech/microphone_faults.h"

#include "mien/virtual/fault_table.h"

namespace mien::virt {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MicrophoneFaults, clock_offset_s, clock_drift_ppm, radio_delay_min_ms,
                                   radio_delay_ms, packet_loss, sensor_loss_per_hour, level, noise, offset)

Result<MicrophoneFaults> parse_microphone_faults(std::string_view text, const std::string& where) {
  static constexpr FaultLimit kLimits[] = {
      {"packet_loss", 0, 1}, {"noise", 0, 1}, {"offset", 0, 1}, {"clock_drift_ppm", 0, 1e4}};
  return parse_fault_table<MicrophoneFaults>(text, where, kLimits);
}

}  // namespace mien::virt
