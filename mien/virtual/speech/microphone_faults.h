#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// What a simulated microphone is like and what is wrong with it, as the table [faults.microphone] of a rig
/// file states it: one sigma unless said otherwise, drawn once a microphone. The defaults are a perfect
/// microphone in a silent room.
struct MicrophoneFaults {
  std::array<double, 2> clock_offset_s{};  ///< Its clock at the session's start, uniform.
  double clock_drift_ppm = 0;
  /// Every block arrives so long after its end: what a radio and its buffers take. No clock tells it, so
  /// sound lags by what it exceeds other devices' delay.
  double radio_delay_min_ms = 0;
  double radio_delay_ms = 0;        ///< Mean of the exponential part of the arrival delay.
  double packet_loss = 0;           ///< Share of blocks that never arrive, 0 to 1.
  double sensor_loss_per_hour = 0;  ///< Mean number of times an hour that it falls silent for 1 to 10 s.
  double level = 1;                 ///< By which sound is multiplied, before it is clipped.
  double noise = 0;                 ///< Root mean square of the room's and its own, share of full scale.
  double offset = 0;                ///< Direct current, share of full scale.

  bool operator==(const MicrophoneFaults&) const = default;
};

/// Errors: malformed TOML, unknown keys; out_of_range: as read_fault_table() has it, a share above 1, drift
/// above 1e4 ppm. `where` names the source in messages.
[[nodiscard]] Result<MicrophoneFaults> parse_microphone_faults(std::string_view toml,
                                                               const std::string& where);

}  // namespace mien::virt
