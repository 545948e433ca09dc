#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/live/engine.h"
#include "mien/sensor/rig.h"

namespace mien::app {

/// What `--audio` names on this machine: "page" a browser's microphone (page_feed()), a WAV file where it
/// ends in ".wav" or is there, else a microphone (microphone_feed()). Errors: theirs.
[[nodiscard]] Result<live::Feed> sound_feed(const std::string& what);

/// The sound of a WAV file, as if it were spoken from the session's beginning on: in real time, once. Errors:
/// read_file's, parse_wav's, BlockMaker::create's; truncated (no sound), out_of_range (more than two hours).
/// While the session is not to hear, the file goes on unheard. Says on stderr where the file is cut short.
[[nodiscard]] Result<live::Feed> file_feed(const std::string& file);

/// What `--audio` names where a microphone on the network is to be heard, which no feed brings.
inline constexpr std::string_view kFromNetwork = "network";

/// Whether the rig's first microphone is bound, in the file, to a device that is not this machine's: it is on
/// the network, and nothing here may open one in its place unless it is named.
[[nodiscard]] bool hears_network(const sensor::Rig& rig);

/// The rig with a microphone: the one that it has, which must be bound to a device, or one more beside its
/// other sensors. What is heard on this machine is bound to speech::kThisMachine, which nobody on a network
/// can be; `from_network`: it is left bound as it is, and one more is bound to speech::kAnyMicrophone.
/// `hears_by`: as sensor::Mount has it; empty: as the rig says. Errors: bad_usage (its microphone is bound to
/// no device, or from the network to this machine's), parse_rig's (it has no room for one).
[[nodiscard]] Result<sensor::Rig> with_microphone(sensor::Rig rig, const std::string& hears_by,
                                                  bool from_network);

}  // namespace mien::app
