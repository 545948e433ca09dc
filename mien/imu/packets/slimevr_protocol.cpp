#include "mien/imu/packets/slimevr_protocol.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/units.h"

namespace mien::imu {
namespace {

using sensor::DeviceKey;
using sensor::Inbox;
using sensor::Verdict;

/// Most boards: bounds memory against hostile handshakes.
constexpr std::size_t kMaxBoards = 64;
constexpr std::size_t kMaxChannels = 32;
constexpr Duration kHeartbeatPeriod = std::chrono::milliseconds(500);
/// Boards silent for longer get no heartbeats: a tracker drops its server after 3 s.
constexpr Duration kGone = std::chrono::seconds(10);
/// Boards without bundles send accelerations in datagrams of their own: most rotations that may use one.
constexpr int kMaxAccelerationAge = 4;
/// From this version on accelerations are in the axes of the rotations.
constexpr std::uint32_t kAlignedSince = 22;

/// From their world (+Z up) to ours (+Y up).
const Quat kUpright(std::numbers::sqrt2 / 2, -std::numbers::sqrt2 / 2, 0, 0);

}  // namespace

bool SlimeVrProtocol::recognises(std::span<const std::byte> datagram) const {
  return slimevr::is_tracker_datagram(datagram);
}

SlimeVrProtocol::Board* SlimeVrProtocol::board_of(sensor::Peer peer) {
  const auto board =
      std::find_if(boards_.begin(), boards_.end(), [&](const Board& b) { return b.peer == peer; });
  return board == boards_.end() ? nullptr : &*board;
}

SlimeVrProtocol::Channel* SlimeVrProtocol::channel_of(Board& board, std::uint8_t number, Inbox& inbox) {
  const auto channel = std::find_if(board.channels.begin(), board.channels.end(),
                                    [&](const Channel& c) { return c.number == number; });
  if (channel != board.channels.end()) return &*channel;
  if (board.channels.size() == kMaxChannels) return nullptr;
  inbox.announcements.push_back({.from = {board.mac, number}, .firmware = board.firmware});
  board.channels.push_back({.number = number});
  return &board.channels.back();
}

Verdict SlimeVrProtocol::receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                                 Inbox& inbox) {
  messages_.clear();
  const auto header = slimevr::parse_tracker_datagram(datagram, messages_);
  if (!header) return Verdict::malformed;
  if (messages_.size() == 1)
    if (const auto* handshake = std::get_if<slimevr::Handshake>(&messages_.front()))
      return greet(arrival, peer, *handshake, inbox);
  Board* board = board_of(peer);
  if (board == nullptr) return Verdict::ignored;
  if (header->number != 0 && header->number <= board->last_number) return Verdict::ignored;
  if (header->number != 0) board->last_number = header->number;
  board->received = arrival;

  const std::size_t readings = inbox.readings.size();
  const std::size_t batteries = inbox.batteries.size();
  const std::size_t announcements = inbox.announcements.size();
  for (const slimevr::TrackerMessage& message : messages_) take(*board, message, inbox);
  finish(*board, arrival, header->number, inbox);
  if (inbox.readings.size() > readings) return Verdict::taken;
  inbox.alive = DeviceKey{board->mac, 0};
  const bool used = inbox.batteries.size() > batteries || inbox.announcements.size() > announcements ||
                    header->type == slimevr::Heartbeat::kType || header->type == slimevr::Acceleration::kType;
  return used ? Verdict::taken : Verdict::ignored;
}

Verdict SlimeVrProtocol::greet(HostTime arrival, sensor::Peer peer, const slimevr::Handshake& handshake,
                               Inbox& inbox) {
  if (handshake.mac == 0) return Verdict::ignored;  // No identity that a rig could bind.
  // Replaces the peer's earlier board, and nobody else's: anyone can say a number.
  std::erase_if(boards_, [&](const Board& b) { return b.peer == peer && b.mac != handshake.mac; });
  auto board = std::find_if(boards_.begin(), boards_.end(), [&](const Board& b) { return b.peer == peer; });
  if (board == boards_.end()) {
    if (boards_.size() == kMaxBoards) {
      // Who never sent a rotation gives way first, and of those, or else of all, who was silent longest.
      boards_.erase(std::ranges::min_element(
          boards_, {}, [](const Board& b) { return std::pair(!b.channels.empty(), b.received); }));
      board = boards_.end();
    }
    board = boards_.insert(board, Board{.peer = peer, .mac = handshake.mac, .next_heartbeat = arrival});
  }
  board->protocol = handshake.protocol;
  board->firmware = handshake.firmware;
  board->last_number = 0;
  board->received = arrival;
  for (Channel& channel : board->channels) {
    channel.clock.restart();
    channel.acceleration_age = kMaxAccelerationAge;
  }
  inbox.alive = DeviceKey{board->mac, 0};
  reply(slimevr::Greeting{}, inbox);
  return Verdict::taken;
}

void SlimeVrProtocol::take(Board& board, const slimevr::TrackerMessage& message, Inbox& inbox) {
  const auto rotate = [&](std::uint8_t number, const std::array<float, 4>& xyzw) {
    Channel* channel = channel_of(board, number, inbox);
    if (channel != nullptr) channel->rotation = xyzw;
  };
  const auto accelerate = [&](std::uint8_t number, const std::array<float, 3>& m_s2) {
    Channel* channel = channel_of(board, number, inbox);
    if (channel == nullptr) return;
    channel->acceleration = m_s2;
    if (board.protocol < kAlignedSince)  // -90 degrees about Z.
      channel->acceleration = {m_s2[1], -m_s2[0], m_s2[2]};
    channel->acceleration_age = 0;
  };
  if (const auto* rotation = std::get_if<slimevr::Rotation>(&message)) {
    if (rotation->data_type == 1) rotate(rotation->sensor, rotation->xyzw);
  } else if (const auto* both = std::get_if<slimevr::RotationAndAcceleration>(&message)) {
    rotate(both->sensor, both->xyzw);
    accelerate(both->sensor, both->m_s2);
  } else if (const auto* acceleration = std::get_if<slimevr::Acceleration>(&message)) {
    accelerate(acceleration->sensor, acceleration->m_s2);
  } else if (const auto* battery = std::get_if<slimevr::Battery>(&message)) {
    const float percent = std::round(std::clamp(battery->level, 0.0F, 1.0F) * 100);
    inbox.batteries.push_back({{board.mac, 0}, static_cast<std::uint8_t>(percent)});
  } else if (const auto* info = std::get_if<slimevr::SensorInfo>(&message)) {
    if (info->state == 1) channel_of(board, info->sensor, inbox);
    const slimevr::SensorInfoAck ack{info->sensor, info->state};
    if (inbox.reply.empty())
      reply(ack, inbox);
    else if (board.acks.size() < kMaxChannels)
      board.acks.push_back(ack);  // One reply a datagram: the others go with the next heartbeat.
  } else if (std::holds_alternative<slimevr::FeatureFlags>(message)) {
    if (inbox.reply.empty()) reply(slimevr::ServerFlags{slimevr::ServerFlags::kBundle}, inbox);
  }
}

void SlimeVrProtocol::finish(Board& board, HostTime arrival, std::uint64_t number, Inbox& inbox) {
  const bool counted = number != 0;
  const bool of_sampling = std::any_of(messages_.begin(), messages_.end(), [](const auto& message) {
    return std::holds_alternative<slimevr::Rotation>(message) ||
           std::holds_alternative<slimevr::Acceleration>(message) ||
           std::holds_alternative<slimevr::RotationAndAcceleration>(message);
  });
  for (Channel& channel : board.channels) {
    if (counted && !of_sampling) channel.clock.pass();
    if (!channel.rotation) continue;
    const auto& [x, y, z, w] = *channel.rotation;
    const Quat q_world_sensor = canonical(kUpright * Quat(w, x, y, z));
    Vec3 force = q_world_sensor.conjugate() * Vec3(0, kStandardGravity_m_s2, 0);
    if (channel.acceleration_age < kMaxAccelerationAge) {
      force += Vec3(channel.acceleration[0], channel.acceleration[1], channel.acceleration[2]);
      ++channel.acceleration_age;
    }
    channel.rotation.reset();
    sensor::Sample sample;
    sample.kind = sensor::SampleKind::imu_fused;
    sample.sequence = static_cast<std::uint32_t>(number);
    sample.time = channel.clock.add(arrival, number);
    sample.time_estimated = true;
    sample.count = 7;
    std::ranges::copy(wxyz_of(q_world_sensor), sample.values.begin());
    std::ranges::copy(force.cast<float>(), sample.values.begin() + 4);
    inbox.readings.push_back({.from = {board.mac, channel.number}, .sample = sample});
  }
}

void SlimeVrProtocol::reply(const slimevr::ServerMessage& message, Inbox& inbox) {
  writer_.clear();
  slimevr::encode_server_message(message, writer_);
  inbox.reply.assign(writer_.bytes().begin(), writer_.bytes().end());
}

void SlimeVrProtocol::heartbeats(HostTime now, std::vector<Outgoing>& out) {
  const auto add = [&](sensor::Peer peer, const slimevr::ServerMessage& message) {
    ByteWriter writer;
    slimevr::encode_server_message(message, writer);
    out.push_back({peer, writer.release()});
  };
  for (Board& board : boards_) {
    for (const slimevr::SensorInfoAck& ack : board.acks) add(board.peer, ack);
    board.acks.clear();
    if (now - board.received > kGone || now < board.next_heartbeat) continue;
    add(board.peer, slimevr::ServerHeartbeat{});
    add(board.peer, slimevr::Ping{++pings_});
    board.next_heartbeat = now + kHeartbeatPeriod;
  }
}

}  // namespace mien::imu
