#include "mien/imu/packets/node_protocol.h"

#include <sodium.h>

#include <algorithm>

#include "mien/imu/packets/packet.h"

namespace mien::imu {
namespace {

using sensor::DeviceKey;
using sensor::Inbox;
using sensor::Verdict;

/// Most nodes with replay windows: bounds memory against hostile key holders.
constexpr std::size_t kMaxSealedNodes = 256;

/// Verdict by error: unknown version or type, unknown key, or malformed.
Verdict verdict_of(const Error& error) {
  const bool refused = error.code == ErrorCode::unsupported || error.code == ErrorCode::mismatch;
  return refused ? Verdict::refused : Verdict::malformed;
}

}  // namespace

Result<NodeProtocol> NodeProtocol::create(NodeProtocolSettings settings) {
  if (sodium_init() < 0) return fail(ErrorCode::internal, "libsodium does not start");
  ByteWriter scratch;
  if (!encode_node_message(
          Welcome{.session = settings.session, .heartbeat = settings.heartbeat, .host = settings.host_name},
          scratch))
    return fail(ErrorCode::bad_usage, "a host that no welcome can name", "node protocol");
  for (std::size_t i = 0; i < settings.keys.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (settings.keys[i].id == settings.keys[k].id)
        return fail(ErrorCode::bad_usage, "two keys have one id", "node protocol");
  return NodeProtocol(std::move(settings));
}

bool NodeProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_node_packet(datagram);
}

Verdict NodeProtocol::receive(HostTime, sensor::Peer, std::span<const std::byte> datagram, Inbox& inbox) {
  seal_.reset();
  if (is_sealed(datagram)) return open(datagram, inbox);
  return settings_.keys.empty() ? take(datagram, inbox) : Verdict::refused;
}

Verdict NodeProtocol::open(std::span<const std::byte> datagram, Inbox& inbox) {
  const auto header = open_sealed(settings_.keys, datagram, inbox.opened);
  if (!header) return verdict_of(header.error());
  const auto refuse = [&] {
    inbox.opened.clear();
    return Verdict::refused;
  };
  const bool is_hello =
      is_node_packet(inbox.opened) && inbox.opened[5] == static_cast<std::byte>(NodePacketType::hello);
  // A sealed packet must carry this session's token: replays of earlier sessions are rejected.
  if ((header->counter & SealHeader::kFromHost) != 0 || (header->session != settings_.session && !is_hello))
    return refuse();
  if (windows_.size() == kMaxSealedNodes && !windows_.contains(header->device)) return refuse();
  if (!windows_[header->device].accept(header->counter)) return refuse();
  // The inner packet must be of the device in the seal.
  ByteReader device(inbox.opened);
  device.take(8);
  if (device.little<std::uint64_t>() != header->device) return refuse();
  seal_ = *header;
  const Verdict verdict = take(inbox.opened, inbox);
  if (verdict == Verdict::malformed) inbox.opened.clear();
  return verdict;
}

Verdict NodeProtocol::take(std::span<const std::byte> packet, Inbox& inbox) {
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
  plain_.clear();
  // Cannot fail: create() checked the welcome, and an echo repeats checked fields.
  if (!encode_node_message(message, plain_)) return;
  std::span<const std::byte> bytes = plain_.bytes();
  if (seal_) {
    const auto key = std::find_if(settings_.keys.begin(), settings_.keys.end(),
                                  [&](const SealKey& k) { return k.id == seal_->key_id; });
    sealed_.clear();
    if (!seal_packet(*key,
                     {.key_id = seal_->key_id,
                      .device = seal_->device,
                      .counter = SealHeader::kFromHost | sent_++,
                      .session = settings_.session},
                     bytes, sealed_))
      return;
    bytes = sealed_.bytes();
  }
  inbox.reply.assign(bytes.begin(), bytes.end());
}

}  // namespace mien::imu
