#pragma once

#include <cstdint>
#include <string>

#include "mien/core/error.h"
#include "mien/live/engine.h"
#include "mien/sensor/rig.h"

namespace mien::app {

/// What `--audio` names: a WAV file where it ends in ".wav" or is there, else a microphone
/// (microphone_feed()). Errors: those of either.
[[nodiscard]] Result<live::Feed> sound_feed(const std::string& what, std::uint64_t device);

/// The sound of a WAV file, as if it were spoken from the session's beginning on: in real time, once.
/// `device`: whose blocks they are. Errors: read_file's, parse_wav's, BlockMaker::create's; truncated (no
/// sound), out_of_range (more than two hours). While the session is not to hear, the file goes on unheard.
[[nodiscard]] Result<live::Feed> file_feed(const std::string& file, std::uint64_t device);

/// A rig with a microphone: the one that it has, which must be bound to a device, or one more beside its
/// other sensors, bound to "02:4D:49:53:4E:00".
struct HearingRig {
  sensor::Rig rig;
  std::uint64_t device = 0;  ///< The microphone's.
};
/// `hears_by`: as sensor::Mount has it; empty: as the rig says. Errors: bad_usage (its microphone is bound to
/// no device), parse_rig's (it has no room for one).
[[nodiscard]] Result<HearingRig> with_microphone(sensor::Rig rig, const std::string& hears_by);

}  // namespace mien::app
