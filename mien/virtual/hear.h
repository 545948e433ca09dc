#pragma once

#include <functional>
#include <vector>

#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/network.h"
#include "mien/virtual/session.h"

namespace mien::virt {

/// Appends a datagram's samples, as those of the rig's sensors; nothing where it does not parse.
using Decode = std::function<void(const Datagram&, std::vector<sensor::Sample>&)>;

/// Virtual nodes' own packets: a packet is of the node whose id it carries.
[[nodiscard]] Decode decode_nodes(const sensor::Rig& rig);

/// Fills in a session's entries, samples and ticks from what arrived, as a live session hears it: what does
/// not parse is logged and nothing more. Shape: `arrived` by arrival. `on_tick` is told of every tick, with
/// the time lines as they are then.
void hear(std::vector<Datagram> arrived, const sensor::Rig& rig, const Decode& decode,
          VirtualSession& session,
          const std::function<void(const take::Tick&, const sensor::TimeLines&)>& on_tick);

}  // namespace mien::virt
