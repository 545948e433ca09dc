#include "mien/virtual/imu/mien_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/sensor/bindings.h"

namespace mien::virt {

namespace {

imu::Hello hello_of(std::size_t sensor, std::string site) {
  // A name that no hello can carry is not announced; the rig's binding or a tap must do.
  if (site.size() > imu::kMaxNodeText) site.clear();
  return {.device = sensor::virtual_device(sensor),
          .rate_hz = kImuRateHz,
          .firmware = "virtual",
          .sites = {std::move(site)}};
}

}  // namespace

MienNode::MienNode(std::size_t sensor, std::string site, const VirtualClock& clock,
                   const DeviceFaults& faults)
    : greeting_(hello_of(sensor, std::move(site))), clock_(clock), faults_(faults) {}

void MienNode::begin(HostTime start) {
  start_ = start;
  greeting_.begin(start);
}

Result<void> MienNode::play(std::span<const VirtualPacket> packets) {
  for (const VirtualPacket& packet : packets) {
    if (packet.lost) continue;
    MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, encode_device_packet(packet, {device(), 0}, faults_));
    samples_.emplace(packet.arrival.time_since_epoch(), std::move(bytes));
  }
  return {};
}

HostTime MienNode::due() const {
  HostTime due = greeting_.due();
  if (start_ && !samples_.empty()) due = std::min(due, *start_ + samples_.begin()->first);
  return due;
}

std::optional<std::vector<std::byte>> MienNode::next_datagram(HostTime now) {
  if (auto hello = greeting_.next_hello(now)) return hello;
  if (!start_) return std::nullopt;
  if (!samples_.empty() && now >= *start_ + samples_.begin()->first)
    return std::move(samples_.extract(samples_.begin()).mapped());
  if (!greeting_.heartbeat_due(now)) return std::nullopt;
  const double percent = 100 * battery_level(now - *start_);
  return greeting_.heartbeat(static_cast<std::uint8_t>(std::lround(percent)),
                             clock_.device(to_seconds(now - *start_)));
}

}  // namespace mien::virt
