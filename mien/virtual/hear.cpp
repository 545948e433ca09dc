#include "mien/virtual/hear.h"

#include <utility>

#include "mien/imu/packets/packet.h"
#include "mien/sensor/ticks.h"
#include "mien/virtual/imu/device_packet.h"

namespace mien::virt {

Decode decode_nodes(const sensor::Rig& rig) {
  return [sensors = rig.sensors.size()](const Datagram& datagram, std::vector<sensor::Sample>& out) {
    const auto packet = imu::parse_packet(datagram.bytes);
    // Ids below the first node's wrap round to more than any rig has.
    const std::uint64_t sensor = packet ? packet->device - virtual_device(0) : sensors;
    if (packet && sensor < sensors) imu::append_samples(*packet, static_cast<std::uint16_t>(sensor), out);
  };
}

void hear(std::vector<Datagram> arrived, const sensor::Rig& rig, const Decode& decode,
          VirtualSession& session,
          const std::function<void(const take::Tick&, const sensor::TimeLines&)>& on_tick) {
  sensor::TickRule rule(rig);
  std::vector<sensor::Sample> decoded;
  const auto fire = [&](HostTime now) {
    while (const auto due = rule.due(now)) {
      const take::Tick tick{due->index, static_cast<std::int64_t>(session.entries.size()), due->fired,
                            due->frame};
      session.ticks.push_back(tick);
      on_tick(tick, rule.lines());
    }
  };
  for (Datagram& datagram : arrived) {
    fire(datagram.time);
    const auto id = static_cast<std::int64_t>(session.entries.size()) + 1;
    decoded.clear();
    decode(datagram, decoded);
    for (const sensor::Sample& sample : decoded) {
      session.samples.push_back({id, datagram.time, sample});
      rule.add(datagram.time, sample);
    }
    session.entries.push_back({id, datagram.time, "virtual", std::move(datagram.bytes)});
    fire(datagram.time);
  }
}

}  // namespace mien::virt
