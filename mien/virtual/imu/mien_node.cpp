#include "mien/virtual/imu/mien_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/sensor/bindings.h"
#include "mien/virtual/imu/device_packet.h"

namespace mien::virt {

MienNode::MienNode(std::size_t sensor, std::string site, const VirtualClock& clock,
                   const DeviceFaults& faults)
    : clock_(clock), faults_(faults) {
  hello_.device = sensor::virtual_device(sensor);
  hello_.rate_hz = kImuRateHz;
  hello_.firmware = "virtual";
  // A name that no hello can carry is not announced; the rig's binding or a tap must do.
  if (site.size() > imu::kMaxNodeText) site.clear();
  hello_.sites = {std::move(site)};
}

Result<void> MienNode::play(std::span<const VirtualPacket> packets) {
  for (const VirtualPacket& packet : packets) {
    if (packet.lost) continue;
    MIEN_TRY_ASSIGN(std::vector<std::byte> bytes, encode_device_packet(packet, {hello_.device, 0}, faults_));
    samples_.emplace(packet.arrival.time_since_epoch(), std::move(bytes));
  }
  return {};
}

HostTime MienNode::due() const {
  HostTime due = HostTime::max();
  if (next_hello_) due = *next_hello_;
  if (start_ && welcome_) due = std::min(due, next_heartbeat_);
  if (start_ && !samples_.empty()) due = std::min(due, *start_ + samples_.begin()->first);
  return due;
}

std::optional<std::vector<std::byte>> MienNode::next_datagram(HostTime now) {
  if (start_ && welcome_ && now - std::max(received_, *start_) > kReceiverGone) {
    welcome_.reset();
    next_hello_ = now;
  }
  if (next_hello_ && now >= *next_hello_) {
    next_hello_ = now + imu::kHelloPeriod;
    return encoded(hello_);
  }
  if (!start_) return std::nullopt;
  if (!samples_.empty() && now >= *start_ + samples_.begin()->first)
    return std::move(samples_.extract(samples_.begin()).mapped());
  if (welcome_ && now >= next_heartbeat_) {
    next_heartbeat_ = now + welcome_->heartbeat;
    imu::NodeHeartbeat heartbeat;
    heartbeat.device = hello_.device;
    heartbeat.battery_percent = static_cast<std::uint8_t>(std::lround(100 * battery_level(now - *start_)));
    // A clock never shows less than zero, and the wire has microseconds.
    const Duration shown =
        std::max(Duration::zero(), clock_.device(to_seconds(now - *start_)).time_since_epoch());
    heartbeat.time = DeviceTime(std::chrono::floor<std::chrono::microseconds>(shown));
    return encoded(heartbeat);
  }
  return std::nullopt;
}

void MienNode::receive(HostTime now, std::span<const std::byte> datagram) {
  const auto message = imu::parse_node_message(datagram);
  if (!message) return;
  if (const auto* welcome = std::get_if<imu::Welcome>(&*message);
      welcome && welcome->device == hello_.device) {
    if (!welcome_) next_heartbeat_ = now;
    welcome_ = *welcome;
    received_ = now;
    next_hello_.reset();
  } else if (const auto* echo = std::get_if<imu::HeartbeatEcho>(&*message);
             echo && echo->device == hello_.device) {
    received_ = now;
    // Another session, which has not seen the hello.
    if (welcome_ && echo->session != welcome_->session) next_hello_ = now;
  }
}

std::vector<std::byte> MienNode::encoded(const imu::NodeMessage& message) const {
  ByteWriter writer;
  // A message of ours that breaks our own rules would be a defect of this class; nothing is sent then.
  (void)imu::encode_node_message(message, writer);
  return writer.release();
}

}  // namespace mien::virt
