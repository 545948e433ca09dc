#include "mien/virtual/node_greeting.h"

#include <algorithm>

#include "mien/core/bytes.h"
#include "mien/virtual/node.h"

namespace mien::virt {
namespace {

std::vector<std::byte> encoded(const imu::NodeMessage& message) {
  ByteWriter writer;
  // A message of ours that breaks our own rules would be a defect of its node; nothing is sent then.
  (void)imu::encode_node_message(message, writer);
  return writer.release();
}

}  // namespace

HostTime NodeGreeting::due() const {
  HostTime due = next_hello_.value_or(HostTime::max());
  if (start_ && welcome_) due = std::min(due, next_heartbeat_);
  return due;
}

std::optional<std::vector<std::byte>> NodeGreeting::next_hello(HostTime now) {
  if (start_ && welcome_ && now - std::max(received_, *start_) > kReceiverGone) {
    welcome_.reset();
    next_hello_ = now;
  }
  if (!next_hello_ || now < *next_hello_) return std::nullopt;
  next_hello_ = now + imu::kHelloPeriod;
  return encoded(hello_);
}

bool NodeGreeting::heartbeat_due(HostTime now) {
  if (!start_ || !welcome_ || now < next_heartbeat_) return false;
  next_heartbeat_ = now + welcome_->heartbeat;
  return true;
}

std::vector<std::byte> NodeGreeting::heartbeat(std::uint8_t battery_percent, DeviceTime time) const {
  const Duration shown = std::max(Duration::zero(), time.time_since_epoch());
  return encoded(
      imu::NodeHeartbeat{.device = hello_.device,
                         .battery_percent = battery_percent,
                         .time = DeviceTime(std::chrono::floor<std::chrono::microseconds>(shown))});
}

void NodeGreeting::receive(HostTime now, std::span<const std::byte> datagram) {
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

}  // namespace mien::virt
