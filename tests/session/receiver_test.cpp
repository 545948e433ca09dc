#include "mien/session/receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "mien/imu/packets/packet.h"
#include "mien/sensor/bindings.h"
#include "mien/session/replay.h"
#include "tests/session/session_run.h"

namespace mien::session::receiver_test {
namespace {

using sensor::DeviceKey;

/// What a receiver handed on, in order.
class Received final : public SampleConsumer {
 public:
  struct Item {
    std::uint16_t sensor = 0;
    bool rebound = false;
    DeviceTime time;
    DeviceKey device;
  };
  std::vector<Item> items;
  void add(HostTime, const sensor::Sample& sample) override {
    items.push_back({.sensor = sample.sensor, .time = sample.time});
  }
  void rebound(std::uint16_t sensor, const DeviceKey& device, bool) override {
    items.push_back({.sensor = sensor, .rebound = true, .device = device});
  }
  [[nodiscard]] std::ptrdiff_t of(std::uint16_t sensor) const {
    return std::ranges::count_if(items, [&](const Item& i) { return !i.rebound && i.sensor == sensor; });
  }
};

std::unique_ptr<Receiver> receiver(sensor::Rig rig = virt::test::three_sensors()) {
  std::vector<std::unique_ptr<sensor::Protocol>> protocols;
  protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Receiver::create(std::move(rig), std::move(protocols)).value();
}

take::LogEntry page(std::int64_t id, HostTime arrival, std::string_view json) {
  const auto bytes = std::as_bytes(std::span(json));
  return {id, arrival, std::string(kPageSource), {bytes.begin(), bytes.end()}};
}

bool always(const take::Tick&) {
  return true;
}

TEST(Receiver, GivesEverySampleOfTheLogOnceToItsSensor) {
  const virt::VirtualSession performed = test::performance(1);
  Received received;
  ASSERT_TRUE(replay_samples(performed.entries, performed.ticks, *receiver(), received, always));
  ASSERT_EQ(received.items.size(), performed.samples.size());
  for (std::size_t i = 0; i < received.items.size(); ++i) {
    EXPECT_EQ(received.items[i].sensor, performed.samples[i].sample.sensor);
    EXPECT_EQ(received.items[i].time, performed.samples[i].sample.time);
  }
}

TEST(Receiver, ADeviceThatTheLogBindsAnewIsTheOtherSensorFromThereOn) {
  const virt::VirtualSession performed = test::performance(2);
  const std::size_t half = performed.entries.size() / 2;
  std::vector<take::LogEntry> entries(performed.entries.begin(),
                                      performed.entries.begin() + static_cast<std::ptrdiff_t>(half));
  const DeviceKey cheek{sensor::virtual_device(1), 0};
  entries.push_back(page(
      static_cast<std::int64_t>(half) + 1, entries.back().arrival,
      R"({"command": "bind", "sensor": "mentalis", "device": ")" + sensor::format_device(cheek) + "\"}"));
  for (std::size_t i = half; i < performed.entries.size(); ++i) {
    entries.push_back(performed.entries[i]);
    ++entries.back().id;
  }
  Received received;
  ASSERT_TRUE(replay_samples(entries, {}, *receiver(), received, always));
  const auto bound = std::ranges::find_if(received.items, &Received::Item::rebound);
  ASSERT_NE(bound, received.items.end());
  EXPECT_EQ(bound->sensor, 0);
  EXPECT_EQ(bound->device, cheek);
  EXPECT_EQ(std::ranges::count_if(received.items, &Received::Item::rebound), 1);
  // The chin's own board is bound to nothing any more, and the cheek has none.
  EXPECT_GT(std::count_if(bound, received.items.end(), [](const auto& i) { return i.sensor == 0; }), 100);
  EXPECT_EQ(std::count_if(bound, received.items.end(), [](const auto& i) { return i.sensor == 1; }), 0);
  EXPECT_GT(received.of(1), 100);
}

TEST(Receiver, CommandsThatBindNothingArePassedOver) {
  const virt::VirtualSession performed = test::performance(0.5);
  std::vector<take::LogEntry> entries;
  for (const char* json : {R"({"command": "recentre"})",
                           R"({"command": "bind", "sensor": "nose", "device": "02:4D:49:45:4E:01"})",
                           R"({"command": "tap", "sensor": "nose"})", "no command"})
    entries.push_back(
        page(static_cast<std::int64_t>(entries.size()) + 1, performed.entries[0].arrival, json));
  for (const take::LogEntry& entry : performed.entries) {
    entries.push_back(entry);
    entries.back().id += 4;
  }
  Received received;
  ASSERT_TRUE(replay_samples(entries, {}, *receiver(), received, always));
  EXPECT_EQ(received.items.size(), performed.samples.size());
}

TEST(Receiver, StopsWhenAskedAtATick) {
  const virt::VirtualSession performed = test::performance(1);
  Received received;
  int ticks = 0;
  EXPECT_FALSE(replay_samples(performed.entries, performed.ticks, *receiver(), received,
                              [&](const take::Tick&) { return ++ticks < 10; }));
  EXPECT_EQ(ticks, 10);
  EXPECT_LT(received.items.size(), performed.samples.size());
}

TEST(Receiver, RefusesARigThatBindsTwoSensorsToOneDevice) {
  sensor::Rig rig = virt::test::three_sensors();
  rig.sensors[0].device = rig.sensors[2].device = "02:4D:49:45:4E:07";
  const auto refused = Receiver::create(rig, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  rig.sensors[2].device = "a board";
  EXPECT_EQ(Receiver::create(rig, {}).error().code, ErrorCode::malformed);
}

/// The same packet with other values, as a stranger forges it.
std::vector<std::byte> forged(std::span<const std::byte> datagram, float value, Duration later = {}) {
  imu::Packet packet = imu::parse_packet(datagram).value();
  for (auto& values : packet.values) values.fill(value);
  packet.time += later;
  return imu::encode_packet(packet).value();
}

/// Which readings came through: of the device, or forged, which all have one value.
class Accepted final : public SampleConsumer {
 public:
  void add(HostTime arrival, const sensor::Sample& sample) override {
    const bool of_stranger =
        std::ranges::all_of(sample.used(), [&](float v) { return std::abs(v - sample.values[0]) < 1e-6F; });
    (of_stranger ? stranger : device).push_back(arrival);
  }
  void rebound(std::uint16_t, const DeviceKey&, bool) override { ++changes; }
  std::vector<HostTime> stranger, device;
  int changes = 0;
};

TEST(Receiver, AFirstComerWhoIsNoSensorIsPutAsideWithinFiveSeconds) {
  const virt::VirtualSession performed = test::performance(4);
  const auto receiver = receiver_test::receiver();
  Accepted accepted;
  const HostTime begin = performed.entries.front().arrival;
  const HostTime on = begin + std::chrono::seconds(2);  // When the boards are switched on.
  for (const take::LogEntry& entry : performed.entries) {
    if (!imu::is_packet(entry.bytes)) continue;
    receiver->receive(entry.arrival, 99, forged(entry.bytes, 0), accepted);
    if (entry.arrival >= on) receiver->receive(entry.arrival, 1, entry.bytes, accepted);
  }
  ASSERT_FALSE(accepted.device.empty());
  EXPECT_LT(accepted.device.front(), on + std::chrono::seconds(5));
  EXPECT_EQ(accepted.changes, 3) << "each sensor once, and for good";
  EXPECT_LT(accepted.stranger.back(), on + std::chrono::seconds(5));
}

TEST(Receiver, NobodyTakesADeviceOverByClaimingItsId) {
  const virt::VirtualSession performed = test::performance(4);
  for (const float value : {0.0F, 5.0F}) {
    const auto receiver = receiver_test::receiver();
    Accepted accepted;
    for (const take::LogEntry& entry : performed.entries) {
      if (!imu::is_packet(entry.bytes)) continue;
      receiver->receive(entry.arrival, 1, entry.bytes, accepted);
      for (sensor::Peer peer = 90; peer < 100; ++peer)
        receiver->receive(entry.arrival, peer, forged(entry.bytes, value), accepted);
    }
    EXPECT_TRUE(accepted.stranger.empty());
    EXPECT_EQ(accepted.changes, 0);
    EXPECT_EQ(accepted.device.size(), performed.samples.size());
  }
}

TEST(Receiver, StrangersWithManyIdsKeepNoDeviceOut) {
  const virt::VirtualSession performed = test::performance(1);
  const auto receiver = receiver_test::receiver();
  Accepted accepted;
  const auto claim = [&](std::uint64_t device) {
    imu::Packet packet = imu::parse_packet(performed.entries.front().bytes).value();
    packet.device = device;
    receiver->receive(performed.entries.front().arrival, 99, imu::encode_packet(packet).value(), accepted);
  };
  for (std::uint64_t device = 1000; device < 2000; ++device) claim(device);
  for (const take::LogEntry& entry : performed.entries)
    receiver->receive(entry.arrival, 1, entry.bytes, accepted);
  EXPECT_EQ(accepted.device.size(), performed.samples.size());
  Report report;
  receiver->report(performed.entries.back().arrival, report);
  EXPECT_EQ(report.unbound.size(), Receiver::kMaxDevices);
  // A board that is to be bound is met whoever was there before.
  claim(5000);
  receiver->report(performed.entries.back().arrival, report);
  EXPECT_TRUE(std::ranges::any_of(report.unbound, [](const Report::Unbound& one) {
    return one.device == sensor::format_device({5000, 0});
  }));
}

}  // namespace
}  // namespace mien::session::receiver_test
