#include "mien/virtual/imu/sealed_node.h"

#include <variant>

#include "mien/core/bytes.h"
#include "mien/imu/packets/node_message.h"

namespace mien::virt {
namespace {

/// Of any packet of ours: magic, version, type, two bytes, then the device.
constexpr std::size_t kTypeAt = 5;
constexpr std::size_t kDeviceAt = 8;

}  // namespace

std::optional<std::vector<std::byte>> SealedNode::next_datagram(HostTime now) {
  const auto inner = node_.next_datagram(now);
  if (!inner) return std::nullopt;
  ByteReader reader(*inner);
  reader.take(kDeviceAt);
  device_ = reader.little<std::uint64_t>();
  const bool hello = (*inner)[kTypeAt] == static_cast<std::byte>(imu::NodePacketType::hello);
  ByteWriter sealed;
  // A packet of ours that cannot be sealed would be a defect of its node; an empty one is sent then.
  (void)imu::seal_packet(
      key_, {.key_id = key_.id, .device = device_, .counter = counter_++, .session = hello ? 0 : session_},
      *inner, sealed);
  return sealed.release();
}

void SealedNode::receive(HostTime now, std::span<const std::byte> datagram) {
  const auto header = imu::open_sealed({&key_, 1}, datagram, opened_);
  if (!header || header->device != device_ || (header->counter & imu::SealHeader::kFromHost) == 0) return;
  const auto message = imu::parse_node_message(opened_);
  if (!message) return;
  // A welcome begins another session, whose counter begins anew.
  if (std::holds_alternative<imu::Welcome>(*message) && header->session != session_) {
    session_ = header->session;
    host_ = {};
  }
  if (header->session == session_ && host_.accept(header->counter & ~imu::SealHeader::kFromHost))
    node_.receive(now, opened_);
}

}  // namespace mien::virt
