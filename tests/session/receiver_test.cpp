#include "mien/session/receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

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

}  // namespace
}  // namespace mien::session::receiver_test
