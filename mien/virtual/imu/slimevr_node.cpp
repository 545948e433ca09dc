#include "mien/virtual/imu/slimevr_node.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/bytes.h"
#include "mien/core/units.h"
#include "mien/sensor/bindings.h"

namespace mien::virt {
namespace {

namespace slimevr = imu::slimevr;

constexpr Duration kHandshakePeriod = std::chrono::seconds(1);
constexpr Duration kInfoPeriod = std::chrono::seconds(1);
constexpr Duration kFlagsPeriod = std::chrono::milliseconds(500);
constexpr int kMostFlags = 15;
constexpr Duration kBatteryPeriod = std::chrono::seconds(10);
/// The chip's rate is a multiple of it: rotations stand at whole periods of the board's clock.
constexpr Duration kTurnPeriod = std::chrono::milliseconds(10);
constexpr float kUnchanged = 1e-4F;

/// From our world, +Y up, to theirs, +Z up: +90 degrees about X.
const Quat kToTheirWorld(std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, 0, 0);

bool unchanged(const std::array<float, 4>& a, const std::array<float, 4>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - b[i]) > kUnchanged) return false;
  return true;
}

}  // namespace

SlimeVrNode::SlimeVrNode(std::size_t sensor, const VirtualClock& clock)
    : mac_(sensor::virtual_device(sensor)), clock_(clock) {}

Result<void> SlimeVrNode::play(std::span<const VirtualPacket> packets) {
  for (const VirtualPacket& packet : packets)
    for (const sensor::Sample& sample : packet.samples) fuse(sample, packet);
  return {};
}

void SlimeVrNode::fuse(const sensor::Sample& sample, const VirtualPacket& packet) {
  const auto& v = sample.values;
  const Vec3 gyro_rad_s(v[0], v[1], v[2]);
  const Vec3 force_m_s2(v[3], v[4], v[5]);
  const double dt_s = before_ ? to_seconds(sample.time - before_->time) : 1 / kImuRateHz;
  fusion_.add(dt_s, gyro_rad_s, force_m_s2);
  latest_ = {sample.time, fusion_.orientation(), force_m_s2};
  if (!before_) {
    before_ = latest_;
    next_mark_ = DeviceTime((sample.time.time_since_epoch() / kTurnPeriod + 1) * kTurnPeriod);
  }
  for (; next_mark_ <= sample.time; next_mark_ += kTurnPeriod) {
    Turn turn = turn_at(next_mark_);
    turn.arrival = from_seconds(clock_.true_s(next_mark_)) + packet.delay;
    if (!turns_.empty()) turn.arrival = std::max(turn.arrival, turns_.back().arrival);
    turn.lost = packet.lost;
    turns_.push_back(turn);
  }
  before_ = latest_;
}

/// Between the two newest samples.
SlimeVrNode::Turn SlimeVrNode::turn_at(DeviceTime mark) const {
  const double u = to_seconds(mark - before_->time) / to_seconds(latest_.time - before_->time);
  const Quat q_world_sensor = before_->q_world_sensor.slerp(u, latest_.q_world_sensor);
  const Vec3 force_m_s2 = (1 - u) * before_->force_m_s2 + u * latest_.force_m_s2;
  const Vec3 acceleration = force_m_s2 - q_world_sensor.conjugate() * Vec3(0, kStandardGravity_m_s2, 0);
  const Quat theirs = kToTheirWorld * q_world_sensor;
  Turn turn;
  turn.xyzw = {static_cast<float>(theirs.x()), static_cast<float>(theirs.y()), static_cast<float>(theirs.z()),
               static_cast<float>(theirs.w())};
  // One of two signs, and the same from moment to moment.
  if (!turns_.empty()) {
    float dot = 0;
    for (std::size_t i = 0; i < 4; ++i) dot += turn.xyzw[i] * turns_.back().xyzw[i];
    if (dot < 0)
      for (float& component : turn.xyzw) component = -component;
  }
  for (std::size_t i = 0; i < 3; ++i)
    turn.m_s2[i] = static_cast<float>(acceleration[static_cast<Eigen::Index>(i)]);
  return turn;
}

HostTime SlimeVrNode::due() const {
  if (!pending_.empty()) return pending_.front().first;
  HostTime due = start_ && !turns_.empty() ? *start_ + turns_.front().arrival : HostTime::max();
  if (!greeted_) return std::min(due, next_handshake_);
  due = std::min({due, next_battery_, received_ + kReceiverGone});
  if (next_info_) due = std::min(due, *next_info_);
  if (next_flags_) due = std::min(due, *next_flags_);
  return due;
}

std::optional<std::vector<std::byte>> SlimeVrNode::next_datagram(HostTime now) {
  if (greeted_ && now - received_ >= kReceiverGone) {
    greeted_ = false;
    pending_.clear();
    next_handshake_ = now;
  }
  if (!greeted_ && now >= next_handshake_) {
    put(next_handshake_, slimevr::Handshake{.firmware = "virtual", .mac = mac_});
    next_handshake_ = now + kHandshakePeriod;
  }
  if (greeted_ && next_info_ && now >= *next_info_) {
    put(*next_info_, slimevr::SensorInfo{});
    next_info_ = now + kInfoPeriod;
  }
  if (greeted_ && next_flags_ && now >= *next_flags_) {
    put(*next_flags_, slimevr::FeatureFlags{});
    next_flags_ = now + kFlagsPeriod;
    if (++flags_asked_ == kMostFlags) next_flags_.reset();
  }
  if (greeted_ && now >= next_battery_) {
    const auto level = static_cast<float>(battery_level(now - start_.value_or(now)));
    put(next_battery_, slimevr::Battery{.volts = 3.3F + 0.9F * level, .level = level});
    next_battery_ = now + kBatteryPeriod;
  }
  while (start_ && pending_.empty() && !turns_.empty() && now >= *start_ + turns_.front().arrival) {
    const Turn turn = turns_.front();
    turns_.pop_front();
    if (!greeted_ || (last_sent_ && unchanged(*last_sent_, turn.xyzw))) continue;
    last_sent_ = turn.xyzw;  // Lost or not: a board does not know.
    put_turn(*start_ + turn.arrival, turn);
    if (turn.lost) pending_.clear();
  }
  if (pending_.empty()) return std::nullopt;
  std::vector<std::byte> datagram = std::move(pending_.front().second);
  pending_.pop_front();
  return datagram;
}

void SlimeVrNode::put(HostTime due, const slimevr::TrackerMessage& message) {
  // Every message that is put here can be encoded.
  ByteWriter writer;
  if (slimevr::encode_tracker_message(++number_, message, writer))
    pending_.emplace_back(due, writer.release());
}

void SlimeVrNode::put_turn(HostTime due, const Turn& turn) {
  const std::array<slimevr::TrackerMessage, 2> messages = {slimevr::Rotation{.xyzw = turn.xyzw},
                                                           slimevr::Acceleration{.m_s2 = turn.m_s2}};
  if (bundles_) {
    ByteWriter writer;
    if (slimevr::encode_tracker_bundle(++number_, messages, writer))
      pending_.emplace_back(due, writer.release());
  } else {
    for (const slimevr::TrackerMessage& message : messages) put(due, message);
  }
}

void SlimeVrNode::greet(HostTime now) {
  if (greeted_) return;
  greeted_ = true;
  next_info_ = next_flags_ = next_battery_ = now;
  flags_asked_ = 0;
  bundles_ = false;
  last_sent_.reset();
}

void SlimeVrNode::receive(HostTime now, std::span<const std::byte> datagram) {
  const auto message = slimevr::parse_server_message(datagram);
  if (!message) return;
  if (std::holds_alternative<slimevr::Greeting>(*message)) {
    greet(now);
    received_ = now;
  }
  if (!greeted_) return;
  received_ = now;
  if (std::holds_alternative<slimevr::ServerHeartbeat>(*message)) {
    put(now, slimevr::Heartbeat{});
  } else if (const auto* ping = std::get_if<slimevr::Ping>(&*message)) {
    put(now, slimevr::Pong{ping->id});
  } else if (const auto* flags = std::get_if<slimevr::ServerFlags>(&*message)) {
    bundles_ = (flags->bits & slimevr::ServerFlags::kBundle) != 0;
    next_flags_.reset();
  } else if (const auto* ack = std::get_if<slimevr::SensorInfoAck>(&*message)) {
    if (ack->sensor == 0) next_info_.reset();
  }
}

}  // namespace mien::virt
