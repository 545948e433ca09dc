#include "mien/imu/packets/node_protocol.h"

#include "mien/imu/packets/packet.h"

namespace mien::imu {
namespace {

using sensor::DeviceKey;
using sensor::Inbox;
using sensor::Verdict;

/// Verdict by error: unknown version or type, or malformed.
Verdict verdict_of(const Error& error) {
  return error.code == ErrorCode::unsupported ? Verdict::refused : Verdict::malformed;
}

}  // namespace

Result<NodeProtocol> NodeProtocol::create(NodeProtocolSettings settings) {
  ByteWriter scratch;
  if (!encode_node_message(
          Welcome{.session = settings.session, .heartbeat = settings.heartbeat, .host = settings.host_name},
          scratch))
    return fail(ErrorCode::bad_usage, "a host that no welcome can name", "node protocol");
  return NodeProtocol(std::move(settings));
}

bool NodeProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_node_packet(datagram);
}

Verdict NodeProtocol::receive(HostTime, sensor::Peer, std::span<const std::byte> packet, Inbox& inbox) {
  if (is_packet(packet)) return take_samples(packet, inbox);
  auto message = parse_node_message(packet);
  if (!message) return verdict_of(message.error());
  if (const auto* hello = std::get_if<Hello>(&*message)) {
    for (std::size_t i = 0; i < hello->sites.size(); ++i)
      inbox.announcements.push_back({.from = {hello->device, static_cast<std::uint8_t>(i)},
                                     .site = hello->sites[i],
                                     .firmware = hello->firmware});
    reply(Welcome{.device = hello->device,
                  .session = settings_.session,
                  .heartbeat = settings_.heartbeat,
                  .host = settings_.host_name},
          inbox);
    return Verdict::taken;
  }
  if (const auto* heartbeat = std::get_if<NodeHeartbeat>(&*message)) {
    const DeviceKey from{heartbeat->device, 0};
    inbox.alive = from;
    if (heartbeat->battery_percent != kBatteryUnknown)
      inbox.batteries.push_back({from, heartbeat->battery_percent});
    reply(HeartbeatEcho{.device = heartbeat->device, .time = heartbeat->time, .session = settings_.session},
          inbox);
    return Verdict::taken;
  }
  if (const auto* pulse = std::get_if<Pulse>(&*message)) {
    inbox.pulses.push_back({{pulse->device, 0}, pulse->index, pulse->edge});
    return Verdict::taken;
  }
  return Verdict::ignored;  // Another host's messages.
}

Verdict NodeProtocol::take_samples(std::span<const std::byte> bytes, Inbox& inbox) {
  const auto packet = parse_packet(bytes);
  if (!packet) return verdict_of(packet.error());
  const DeviceKey from{packet->device, packet->channel};
  samples_.clear();
  append_samples(*packet, 0, samples_);
  for (std::size_t i = 0; i < samples_.size(); ++i)
    inbox.readings.push_back({.from = from, .sample = samples_[i], .saturated = is_saturated(*packet, i)});
  if (packet->battery_percent != kBatteryUnknown) inbox.batteries.push_back({from, packet->battery_percent});
  return Verdict::taken;
}

void NodeProtocol::reply(const NodeMessage& message, Inbox& inbox) {
  reply_.clear();
  // Cannot fail: create() checked the welcome, and an echo repeats checked fields.
  if (!encode_node_message(message, reply_)) return;
  inbox.reply.assign(reply_.bytes().begin(), reply_.bytes().end());
}

}  // namespace mien::imu
