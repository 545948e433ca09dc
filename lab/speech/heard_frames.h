#pragma once

#include <functional>
#include <optional>
#include <span>

#include "mien/speech/listener.h"
#include "mien/speech/sound_block.h"

namespace mien::lab {

/// Told of each frame's time, and what is shown of whoever speaks; none while nobody does.
using SeeHeard = std::function<void(DeviceTime time, const std::optional<speech::Heard>& heard)>;
/// Streams a sound through a listener, begun anew, as a session hears it: 60 frames a second, each asked for
/// as soon as the block is there that reaches it.
void hear_frames(speech::Listener& listener, std::span<const speech::Block> blocks, const SeeHeard& see);

}  // namespace mien::lab
