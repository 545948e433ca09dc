#include "mien/virtual/sealed_node.h"

#include <algorithm>
#include <variant>

#include "mien/core/bytes.h"
#include "mien/imu/packets/node_message.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::virt {

SealedNode::SealedNode(Node& node, const sensor::SealKey& key, std::uint32_t power_ons)
    : node_(node), key_(key), counter_(std::uint64_t{power_ons} << 32U) {
  // It announces no place: the rig binds its channels.
  if (!node.listens())
    greeting_.emplace(imu::Hello{.device = node.device(), .firmware = "virtual", .sites = {""}});
}

void SealedNode::begin(HostTime start) {
  start_ = start;
  node_.begin(start);
  if (greeting_) greeting_->begin(start);
}

HostTime SealedNode::due() const {
  return greeting_ ? std::min(greeting_->due(), node_.due()) : node_.due();
}

std::optional<std::vector<std::byte>> SealedNode::next_inner(HostTime now) {
  if (!greeting_) return node_.next_datagram(now);
  if (auto hello = greeting_->next_hello(now)) return hello;
  if (auto said = node_.next_datagram(now)) return said;
  // Its own packets carry the charge.
  if (greeting_->heartbeat_due(now))
    return greeting_->heartbeat(sensor::kBatteryUnknown, DeviceTime(now - start_));
  return std::nullopt;
}

std::optional<std::vector<std::byte>> SealedNode::next_datagram(HostTime now) {
  const auto inner = next_inner(now);
  if (!inner) return std::nullopt;
  const bool hello = sensor::is_our_packet(*inner, sensor::kHelloPacketType);
  ByteWriter sealed;
  // A packet of ours that cannot be sealed would be a defect of its node; an empty one is sent then.
  (void)sensor::seal_packet(
      key_, {.key_id = key_.id, .device = device(), .counter = counter_++, .session = hello ? 0 : session_},
      *inner, sealed);
  return sealed.release();
}

void SealedNode::receive(HostTime now, std::span<const std::byte> datagram) {
  const auto header = sensor::open_sealed({&key_, 1}, datagram, opened_);
  if (!header || header->device != device() || (header->counter & sensor::SealHeader::kFromHost) == 0) return;
  const auto message = imu::parse_node_message(opened_);
  if (!message) return;
  // A welcome begins another session, whose counter begins anew.
  if (std::holds_alternative<imu::Welcome>(*message) && header->session != session_) {
    session_ = header->session;
    host_ = {};
  }
  if (header->session != session_ || !host_.accept(header->counter & ~sensor::SealHeader::kFromHost)) return;
  if (greeting_)
    greeting_->receive(now, opened_);
  else
    node_.receive(now, opened_);
}

}  // namespace mien::virt
