#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/feeds.h"

namespace mien::app {

/// Names of this machine's microphones, as PortAudio finds them, the default one first. Errors: io (PortAudio
/// does not start).
[[nodiscard]] Result<std::vector<std::string>> microphones();

/// A microphone of this machine, opened when the session begins and wants to hear: "default", or a part of a
/// name that one of microphones() has. While it cannot be opened, or is pulled out, that is said and it is
/// tried again each second; so is that it stays silent for HeardSound::kSilent. Blocks are counted on the
/// machine's clock over gaps, so that no time is lost. `device`: whose blocks they are. Errors: not_found
/// (none of that name, with those there are), microphones()'.
[[nodiscard]] Result<live::Feed> microphone_feed(const std::string& name, std::uint64_t device);

}  // namespace mien::app
