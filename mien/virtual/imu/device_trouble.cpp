#include "mien/virtual/imu/device_trouble.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
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

/// One packet on its way through all that is wrong with its device.
struct Passing {
  double at_s = 0;  // When it is sent.
  imu::Packet packet;
};

/// False: it is not sent.
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

Result<std::vector<Datagram>> trouble_devices(std::vector<Datagram> sent, const DeviceTroubles& troubles) {
  MIEN_TRY(check(troubles));
  std::multimap<std::uint16_t, Trouble> of_sensor;
  std::vector<Trouble> of_all;
  for (const auto& clock : troubles.clocks) of_sensor.emplace(clock.sensor, off_clock(clock));
  for (const auto& frozen : troubles.frozen) of_sensor.emplace(frozen.sensor, freeze(frozen));
  for (const auto& one : troubles.restarts) of_sensor.emplace(one.sensor, restart(one));
  for (const auto& one : troubles.silences) {
    if (one.sensor)
      of_sensor.emplace(*one.sensor, silence(one));
    else
      of_all.push_back(silence(one));
  }
  for (const auto& shared : troubles.shared_ids) of_sensor.emplace(shared.sensor, share_id(shared));

  std::vector<Datagram> out;
  out.reserve(sent.size());
  for (Datagram& datagram : sent) {
    const auto [begin, end] = of_sensor.equal_range(datagram.source);
    if (begin == end && of_all.empty()) {
      out.push_back(std::move(datagram));
      continue;
    }
    auto packet = imu::parse_packet(datagram.bytes);
    if (!packet)
      return fail(ErrorCode::bad_usage, "troubles need packets of samples: " + packet.error().what,
                  fmt::format("sensor {}", datagram.source));
    Passing passing{to_seconds(datagram.time.time_since_epoch()), std::move(*packet)};
    bool goes = true;
    for (auto trouble = begin; goes && trouble != end; ++trouble) goes = trouble->second(passing);
    for (auto trouble = of_all.begin(); goes && trouble != of_all.end(); ++trouble)
      goes = (*trouble)(passing);
    if (!goes) continue;
    MIEN_TRY_ASSIGN(datagram.bytes, imu::encode_packet(passing.packet));
    out.push_back(std::move(datagram));
  }
  return out;
}

}  // namespace mien::virt
