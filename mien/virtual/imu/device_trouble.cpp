#include "mien/virtual/imu/device_trouble.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <utility>

#include "mien/imu/packets/packet.h"
#include "mien/sensor/bindings.h"

namespace mien::virt {
namespace {

constexpr double kMostTroubleDriftPpm = 1000;
constexpr double kMostStepUs = 10'000;

Result<void> check(const DeviceTroubles& troubles) {
  const auto wrong = [](std::string what) {
    return fail(ErrorCode::out_of_range, std::move(what), "device troubles");
  };
  const auto stretch = [&](double from_s, double to_s) -> Result<void> {
    if (from_s <= to_s) return {};
    return wrong(fmt::format("{} s to {} s is no stretch of time", from_s, to_s));
  };
  for (const auto& clock : troubles.clocks) {
    if (!(std::abs(clock.drift_ppm) <= kMostTroubleDriftPpm))
      return wrong(fmt::format("a drift of {} ppm is beyond {:.0f}", clock.drift_ppm, kMostTroubleDriftPpm));
    if (!(std::abs(clock.step_us) <= kMostStepUs))
      return wrong(fmt::format("a step of {} us is beyond {:.0f}", clock.step_us, kMostStepUs));
    if (!(clock.step_every_s > 0)) return wrong("a clock is stepped without a pause");
  }
  for (const auto& frozen : troubles.frozen) MIEN_TRY(stretch(frozen.from_s, frozen.to_s));
  for (const auto& restart : troubles.restarts) MIEN_TRY(stretch(0, restart.boot_s));
  for (const auto& silence : troubles.silences) MIEN_TRY(stretch(silence.from_s, silence.to_s));
  return {};
}

using Passing = PassingPacket;
using Trouble = std::function<bool(Passing&)>;

Trouble off_clock(const DeviceTroubles::Clock& clock) {
  return [clock, first = std::optional<DeviceTime>()](Passing& passing) mutable {
    imu::Packet& packet = passing.packet;
    if (!first) first = packet.time;
    const double on_s = to_seconds(packet.time - *first);
    const double steps = std::floor(on_s / clock.step_every_s);
    packet.time += from_seconds(1e-6 * (clock.drift_ppm * on_s + clock.step_us * steps));
    if (packet.time.time_since_epoch() < Duration::zero()) packet.time = DeviceTime();
    return true;
  };
}

Trouble freeze(const DeviceTroubles::Frozen& frozen) {
  return [frozen, last = std::optional<imu::Packet>()](Passing& passing) mutable {
    imu::Packet& packet = passing.packet;
    if (passing.at_s < frozen.from_s || passing.at_s >= frozen.to_s || !last) {
      last = packet;
      return true;
    }
    for (std::size_t i = 0; i < packet.count; ++i) packet.values[i] = last->values[last->count - 1U];
    return true;
  };
}

Trouble restart(const DeviceTroubles::Restart& restart) {
  struct Boot {
    DeviceTime time;
    std::uint32_t sequence = 0;
  };
  return [restart, boot = std::optional<Boot>()](Passing& passing) mutable {
    if (passing.at_s < restart.at_s) return true;
    if (passing.at_s < restart.at_s + restart.boot_s) return false;
    imu::Packet& packet = passing.packet;
    if (!boot) boot = {packet.time, packet.sequence};
    // What a late packet of before would say is nothing that the new clock could.
    if (packet.time < boot->time) return false;
    packet.time = DeviceTime(packet.time - boot->time);
    packet.sequence -= boot->sequence;
    return true;
  };
}

Trouble share_id(const DeviceTroubles::SharedId& shared) {
  return [shared](Passing& passing) {
    passing.packet.device = sensor::virtual_device(shared.as);
    return true;
  };
}

Trouble silence(const DeviceTroubles::Silence& silence) {
  return
      [silence](Passing& passing) { return passing.at_s < silence.from_s || passing.at_s >= silence.to_s; };
}

}  // namespace

Result<TroubledDevices> TroubledDevices::create(const DeviceTroubles& troubles) {
  MIEN_TRY(check(troubles));
  TroubledDevices out;
  for (const auto& clock : troubles.clocks) out.of_sensor_.emplace(clock.sensor, off_clock(clock));
  for (const auto& frozen : troubles.frozen) out.of_sensor_.emplace(frozen.sensor, freeze(frozen));
  for (const auto& one : troubles.restarts) out.of_sensor_.emplace(one.sensor, restart(one));
  for (const auto& one : troubles.silences) {
    if (one.sensor)
      out.of_sensor_.emplace(*one.sensor, silence(one));
    else
      out.of_all_.push_back(silence(one));
  }
  for (const auto& shared : troubles.shared_ids) out.of_sensor_.emplace(shared.sensor, share_id(shared));
  return out;
}

Result<bool> TroubledDevices::pass(Datagram& datagram) {
  const auto [begin, end] = of_sensor_.equal_range(datagram.source);
  if (begin == end && of_all_.empty()) return true;
  auto packet = imu::parse_packet(datagram.bytes);
  if (!packet)
    return fail(ErrorCode::bad_usage, "troubles need packets of samples: " + packet.error().what,
                fmt::format("sensor {}", datagram.source));
  Passing passing{to_seconds(datagram.time.time_since_epoch()), std::move(*packet)};
  bool goes = true;
  for (auto trouble = begin; goes && trouble != end; ++trouble) goes = trouble->second(passing);
  for (auto trouble = of_all_.begin(); goes && trouble != of_all_.end(); ++trouble)
    goes = (*trouble)(passing);
  if (!goes) return false;
  MIEN_TRY_ASSIGN(datagram.bytes, imu::encode_packet(passing.packet));
  return true;
}

Result<std::vector<Datagram>> trouble_devices(std::vector<Datagram> sent, const DeviceTroubles& troubles) {
  MIEN_TRY_ASSIGN(TroubledDevices devices, TroubledDevices::create(troubles));
  std::vector<Datagram> out;
  out.reserve(sent.size());
  for (Datagram& datagram : sent) {
    MIEN_TRY_ASSIGN(const bool goes, devices.pass(datagram));
    if (goes) out.push_back(std::move(datagram));
  }
  return out;
}

}  // namespace mien::virt
