#pragma once

#include <functional>
#include <vector>

#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/network.h"
#include "mien/virtual/session.h"

namespace mien::virt {

/// Fills in a session's entries, samples and ticks from what arrived, as a live session hears it: a packet is
/// of the virtual node whose id it carries, and what does not parse is logged and nothing more. Shape:
/// `arrived` by arrival. `on_tick` is told of every tick, with the time lines as they are then.
void hear(std::vector<Datagram> arrived, const sensor::Rig& rig, VirtualSession& session,
          const std::function<void(const take::Tick&, const sensor::TimeLines&)>& on_tick);

}  // namespace mien::virt
