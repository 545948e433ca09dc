#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// What a simulated phone that tracks a face is like and what is wrong with it, as the table [faults.phone]
/// of a rig file states it. The defaults are a perfect phone: it tells every sixtieth of a second as the face
/// is then, at once.
struct PhoneFaults {
  double rate_hz = 60;  ///< Frames a second: 60 or 30.
  /// Its frame numbers count sixtieths whatever its rate, as Live Link Face's do: at 30 a second every other
  /// one comes. Else they count its frames.
  bool counts_sixtieths = true;
  std::array<double, 2> clock_offset_s{};  ///< Its frame counter at the performance's time 0, uniform.
  double clock_drift_ppm = 0;              ///< Of that counter, one sigma.
  /// The face that is told is so much older than its frame says, uniform, drawn once. Arrival tells nothing
  /// of it.
  std::array<double, 2> lag_ms{};
  double smoothing_ms = 0;  ///< Sigma of the Gaussian over time by which weights are smoothed, without lag.
  /// A packet arrives so long after its frame's time, uniform, but never before an earlier one.
  std::array<double, 2> delay_ms{};
  double frames_dropped = 0;      ///< Share of frames that are never sent, 0 to 1: numbers leap.
  double face_loss_per_hour = 0;  ///< Mean number of times an hour that it loses the face, ...
  std::array<double, 2> face_loss_s = {0.5, 4};    ///< ... for so long, uniform: packets have no face then.
  std::array<double, 2> face_lost_between_s = {};  ///< Once more, s from the motion's start; 0, 0: never.

  // Its own error, a shape of the 53 (w' = rest + (1 - rest) gain w + noise, held to 0 to 1).
  double resting_offset = 0;  ///< Sigma of what a face at rest has, upwards; none where the eyes look.
  double gain_error = 0;      ///< Sigma of the gain about 1.
  double noise = 0;           ///< Sigma of a noise that is worth what it was for ...
  double noise_time_s = 10;   ///< ... about so long (Ornstein and Uhlenbeck's); 0: white.

  bool operator==(const PhoneFaults&) const = default;
};

/// A phone as people have them: what looks on where a rig has no table [faults.phone]. Of two phones before
/// one face nothing is published that we know of. Measured on two recorded people (alex_rom_3,
/// second_person) and a captured stream (dao), all of Live Link Face:
///
/// - Dropped, 3 %: six of the stream's 186 frames are missing; of the recordings' 0.1 %.
/// - Resting offset, 0.04: the value that 5 % of a recording's frames are below is 0.035 and 0.045, root mean
///   square over shapes. No face was subtracted from them.
/// - Noise, 0.01 and 10 s: in second_person's quietest seconds a weight's standard deviation is 0.0017, from
///   one of these seconds to another 0.010; this noise has 0.0018 and 0.010. Some of it is the person's own.
/// - Counter: the stream's stood at 25 hours.
///
/// Assumed: delay 60 to 120 ms; lag of one to two frames of 60; smoothing 15 ms; drift 10 ppm; a face lost 6
/// times an hour (others' takes lack it for up to 4 s); gains 0.1 about 1, as of the wearers of `mien study
/// resting`.
[[nodiscard]] PhoneFaults usual_phone();

/// Errors: malformed TOML, unknown keys; out_of_range: as read_fault_table() has it, a rate that is neither
/// 60 nor 30, a share or a sigma of weights above 1, lag, delay or smoothing above 2 s, drift above 1e4 ppm.
/// `where` names the source in messages.
[[nodiscard]] Result<PhoneFaults> parse_phone_faults(std::string_view toml, const std::string& where);

}  // namespace mien::virt
