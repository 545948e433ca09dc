#include "mien/session/receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "mien/imu/packets/packet.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/phone/live_link.h"
#include "mien/sensor/bindings.h"
#include "mien/session/command.h"
#include "mien/session/replay.h"
#include "tests/phone/live_link_bytes.h"
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
  void add(HostTime, const sensor::Sample& sample, std::span<const std::byte>) override {
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

/// Entries of a log, to a receiver; `at_half` happens when half of them were.
void feed(
    std::span<const take::LogEntry> entries, Receiver& receiver, SampleConsumer& consumer,
    const std::function<void()>& at_half = [] {}) {
  Peers peers;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i == entries.size() / 2) at_half();
    receiver.receive(entries[i].arrival, peers.of(entries[i].source), entries[i].bytes, consumer);
  }
}

TEST(Receiver, GivesEverySampleOfTheLogOnceToItsSensor) {
  const virt::VirtualSession performed = test::performance(1);
  Received received;
  feed(performed.entries, *receiver(), received);
  ASSERT_EQ(received.items.size(), performed.samples.size());
  for (std::size_t i = 0; i < received.items.size(); ++i) {
    EXPECT_EQ(received.items[i].sensor, performed.samples[i].sample.sensor);
    EXPECT_EQ(received.items[i].time, performed.samples[i].sample.time);
  }
}

TEST(Receiver, ADeviceThatIsBoundAnewIsTheOtherSensorFromThereOn) {
  const virt::VirtualSession performed = test::performance(2);
  const DeviceKey cheek{sensor::virtual_device(1), 0};
  Received received;
  const auto receiver = receiver_test::receiver();
  feed(performed.entries, *receiver, received, [&] { receiver->bind(0, cheek, received); });
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

TEST(Receiver, KnowsAtATickWhoIsLostAndWhoSeesNoFace) {
  sensor::Rig rig = virt::test::three_sensors();
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    rig.sensors[i].device = sensor::format_device({sensor::virtual_device(i), 0});
  const auto phone = static_cast<std::uint16_t>(rig.sensors.size());
  rig.sensors.push_back({.name = "phone",
                         .kind = "weights",
                         .role = "truth",
                         .device = sensor::format_device({phone::kLiveLinkDevice, 0})});
  std::vector<std::unique_ptr<sensor::Protocol>> protocols;
  protocols.push_back(std::make_unique<phone::LiveLinkProtocol>());
  const auto receiver = Receiver::create(std::move(rig), std::move(protocols)).value();
  Received received;
  std::vector<std::string> news;
  const auto watch = [&](double at_s) {
    receiver->watch_links(HostTime(from_seconds(at_s)), [&](std::uint16_t sensor, LinkChange what) {
      EXPECT_EQ(sensor, phone);
      news.emplace_back(link_change_name(what));
    });
  };
  const auto hear = [&](double from_s, double to_s, bool face) {
    for (auto n = static_cast<std::int32_t>(60 * from_s); n < 60 * to_s; ++n) {
      phone::test::LiveLinkFields fields{.frame = 1000 + n};
      if (face) fields.values.emplace().fill(0.25F);
      const auto bytes = phone::test::live_link_bytes(fields);
      EXPECT_EQ(receiver->receive(HostTime(from_seconds(n / 60.0)), {1, "a phone"}, bytes, received).verdict,
                sensor::Verdict::taken);
    }
  };
  watch(0);
  EXPECT_FALSE(receiver->is_lost(phone)) << "it was never heard";
  hear(0, 2, true);
  watch(2);
  EXPECT_FALSE(receiver->is_lost(phone) || receiver->has_no_face(phone));
  hear(2, 4, false);
  EXPECT_FALSE(receiver->has_no_face(phone)) << "not asked since";
  watch(4);
  EXPECT_TRUE(receiver->has_no_face(phone));
  EXPECT_FALSE(receiver->is_lost(phone));
  watch(6);
  EXPECT_TRUE(receiver->is_lost(phone));
  EXPECT_FALSE(receiver->has_no_face(phone));
  hear(7, 8, true);
  watch(8);
  EXPECT_FALSE(receiver->is_lost(phone) || receiver->has_no_face(phone));
  EXPECT_EQ(news, (std::vector<std::string>{"face_lost", "sensor_lost", "sensor_back", "face_back"}));
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

TEST(Receiver, RotationsOfTheLabComeFromALogAndFromNoDevice) {
  const sensor::Sample rotation{.kind = sensor::SampleKind::imu_head_relative, .count = 3};
  imu::Packet packet = imu::make_packet({&rotation, 1}).value();
  packet.device = sensor::virtual_device(0);
  const std::vector<std::byte> bytes = imu::encode_packet(packet).value();
  const auto receiver = receiver_test::receiver();
  Received received;
  const auto live = receiver->receive({}, 1, bytes, received);
  EXPECT_EQ(live.verdict, sensor::Verdict::refused);
  EXPECT_TRUE(received.items.empty());
  Report report;
  receiver->report({}, report);
  EXPECT_EQ(report.refused, 1U);
  EXPECT_EQ(receiver->receive_logged({}, 1, bytes, {}, received).samples.size(), 1U);
}

/// The same packet with other values, as a stranger forges it.
std::vector<std::byte> forged(std::span<const std::byte> datagram, float value, Duration later = {}) {
  imu::Packet packet = imu::parse_packet(datagram).value();
  for (auto& values : packet.values) values.fill(value);
  packet.time += later;
  return imu::encode_packet(packet).value();
}

/// Which readings came through: of the device, or forged, which all have one value but for rounding.
class Accepted final : public SampleConsumer {
 public:
  void add(HostTime arrival, const sensor::Sample& sample, std::span<const std::byte>) override {
    const bool of_stranger =
        std::ranges::all_of(sample.used(), [&](float v) { return std::abs(v - sample.values[0]) < 0.01F; });
    (of_stranger ? stranger : device).push_back(arrival);
  }
  void rebound(std::uint16_t, const DeviceKey&, bool) override { ++changes; }
  void contested(std::uint16_t, std::string_view accepted, std::string_view other) override {
    contests.push_back(std::string(accepted) + " not " + std::string(other));
  }
  std::vector<HostTime> stranger, device;
  std::vector<std::string> contests;
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

/// A performance in which somebody forges every packet a moment later, well enough to pass for a sensor.
struct TwoSenders {
  static constexpr const char* kBoards = "udp://10.0.0.1:5005";
  static constexpr const char* kForger = "udp://10.0.0.9:5005";
  std::vector<take::LogEntry> entries;
  explicit TwoSenders(double seconds, Duration later = {}) {
    for (const take::LogEntry& entry : test::performance(seconds).entries) {
      if (!imu::is_packet(entry.bytes)) continue;
      const auto id = static_cast<std::int64_t>(entries.size());
      entries.push_back({id + 1, entry.arrival, kBoards, entry.bytes});
      entries.push_back({id + 2, entry.arrival, kForger, forged(entry.bytes, 5, later)});
    }
  }
};

TEST(Receiver, TwoSendersOfOneIdAreBothShownAndOneIsChosen) {
  const TwoSenders both(4);
  const auto receiver = receiver_test::receiver();
  Accepted accepted;
  Peers peers;
  const auto play = [&](std::size_t from, std::size_t to, const char* only = nullptr, Duration later = {}) {
    for (std::size_t i = from; i < to; ++i)
      if (const take::LogEntry& e = both.entries[i]; only == nullptr || e.source == only)
        receiver->receive(e.arrival + later, peers.of(e.source), e.bytes, accepted);
    Report report;
    receiver->report(both.entries[to - 1].arrival + later, report);
    return report;
  };
  const std::size_t part = both.entries.size() / 4;
  Report report = play(0, part);
  for (const Report::Link& link : report.links) {
    EXPECT_EQ(link.source, TwoSenders::kBoards);
    EXPECT_EQ(link.health.state, sensor::LinkState::duplicate);
    ASSERT_EQ(link.rivals.size(), 1u);
    EXPECT_EQ(link.rivals[0].source, TwoSenders::kForger);
    EXPECT_FALSE(link.rivals[0].implausible);
  }
  EXPECT_TRUE(accepted.stranger.empty());
  EXPECT_EQ(accepted.contests,
            std::vector<std::string>(3, std::string(TwoSenders::kBoards) + " not " + TwoSenders::kForger));

  // One sensor's sender is chosen; the others' stay.
  EXPECT_FALSE(receiver->hear(0, "udp://10.0.0.7:5005", accepted));
  EXPECT_EQ(accepted.changes, 0);
  ASSERT_TRUE(receiver->hear(0, TwoSenders::kForger, accepted));
  EXPECT_EQ(accepted.changes, 1);
  report = play(part, 2 * part);
  EXPECT_EQ(report.links[0].source, TwoSenders::kForger);
  ASSERT_EQ(report.links[0].rivals.size(), 1u);
  EXPECT_EQ(report.links[0].rivals[0].source, TwoSenders::kBoards);
  EXPECT_EQ(report.links[1].source, TwoSenders::kBoards);
  EXPECT_FALSE(accepted.stranger.empty());
  EXPECT_EQ(accepted.changes, 1);

  // And chosen otherwise.
  ASSERT_TRUE(receiver->hear(0, TwoSenders::kBoards, accepted));
  const std::size_t of_stranger = accepted.stranger.size();
  report = play(2 * part, 3 * part);
  EXPECT_EQ(report.links[0].source, TwoSenders::kBoards);
  EXPECT_EQ(accepted.stranger.size(), of_stranger);

  // Who was chosen and falls silent has no place any more, and who took it is nobody's rival.
  report = play(3 * part, 4 * part, TwoSenders::kForger, std::chrono::seconds(10));
  EXPECT_EQ(report.links[0].source, TwoSenders::kForger);
  EXPECT_TRUE(report.links[0].rivals.empty());
}

/// Two senders, the boards but for a pause; which of the forger's readings were accepted, and the links at
/// the end.
struct Paused {
  Accepted accepted;
  Report report;
  Paused(double seconds, double from_s, double to_s) {
    const TwoSenders both(seconds, std::chrono::hours(1));
    const auto receiver = receiver_test::receiver();
    Peers peers;
    const HostTime begin = both.entries.front().arrival;
    for (const take::LogEntry& e : both.entries) {
      const double at_s = to_seconds(e.arrival - begin);
      if (e.source == TwoSenders::kBoards && at_s >= from_s && at_s < to_s) continue;
      receiver->receive(e.arrival, peers.of(e.source), e.bytes, accepted);
    }
    receiver->report(both.entries.back().arrival, report);
  }
};

TEST(Receiver, WhoSentBesideADeviceDoesNotGetItsPlaceWhenItPauses) {
  const Paused session(7, 3, 6);
  EXPECT_TRUE(session.accepted.stranger.empty());
  EXPECT_EQ(session.accepted.changes, 0);
  EXPECT_EQ(session.report.links[0].source, TwoSenders::kBoards);
}

TEST(Receiver, ADeviceThatIsBackGetsItsPlaceAgain) {
  const Paused session(36, 15, 28);
  EXPECT_FALSE(session.accepted.stranger.empty()) << "after ten seconds";
  EXPECT_EQ(session.accepted.changes, 0) << "what is known of the board holds";
  for (const Report::Link& link : session.report.links) {
    EXPECT_EQ(link.source, TwoSenders::kBoards);
    ASSERT_EQ(link.rivals.size(), 1u);
    EXPECT_EQ(link.rivals[0].source, TwoSenders::kForger);
  }
  const HostTime last_of_stranger = session.accepted.stranger.back();
  EXPECT_GT(std::ranges::count_if(session.accepted.device, [&](HostTime t) { return t > last_of_stranger; }),
            1000);
}

TEST(Receiver, WhoWasChosenStaysHoweverItBehaves) {
  const virt::VirtualSession performed = test::performance(6);
  const auto receiver = receiver_test::receiver();
  Accepted accepted;
  bool asked = false;
  for (const take::LogEntry& entry : performed.entries) {
    if (!imu::is_packet(entry.bytes)) continue;
    receiver->receive(entry.arrival, {1, "udp://boards"}, entry.bytes, accepted);
    receiver->receive(entry.arrival, {9, "udp://zeros"}, forged(entry.bytes, 0), accepted);
    if (!asked && entry.arrival - performed.entries.front().arrival > std::chrono::seconds(1)) {
      asked = true;
      for (const std::uint16_t sensor : {0, 1, 2})
        ASSERT_TRUE(receiver->hear(sensor, "udp://zeros", accepted));
    }
  }
  EXPECT_EQ(accepted.changes, 3);
  EXPECT_GT(accepted.stranger.back(), accepted.device.back() + std::chrono::seconds(5));
  Report report;
  receiver->report(performed.entries.back().arrival, report);
  EXPECT_EQ(report.links[0].rivals.at(0).source, "udp://boards");
}

TEST(Receiver, WhoIsChosenIsAcceptedFromThereOn) {
  const TwoSenders both(2);
  const HostTime at = both.entries[both.entries.size() / 2].arrival;
  Accepted accepted;
  const auto choosing = receiver_test::receiver();
  feed(both.entries, *choosing, accepted,
       [&] { EXPECT_TRUE(choosing->hear(0, TwoSenders::kForger, accepted)); });
  EXPECT_EQ(accepted.changes, 1);
  ASSERT_FALSE(accepted.stranger.empty());
  EXPECT_GE(accepted.stranger.front(), at);
  Accepted unasked;
  feed(both.entries, *receiver(), unasked);
  EXPECT_TRUE(unasked.stranger.empty());
}

/// SlimeVR boards at addresses of their own, one of them bound, and what was accepted of it.
class SlimeVrBoards final : public SampleConsumer {
 public:
  SlimeVrBoards() {
    sensor::Rig rig = virt::test::three_sensors();
    rig.sensors[0].device = sensor::format_device({kMac, 0});
    std::vector<std::unique_ptr<sensor::Protocol>> protocols;
    protocols.push_back(std::make_unique<imu::SlimeVrProtocol>());
    receiver_ = Receiver::create(std::move(rig), std::move(protocols)).value();
  }
  void add(HostTime, const sensor::Sample&, std::span<const std::byte>) override { ++(*speaker_); }
  void rebound(std::uint16_t, const DeviceKey&, bool) override {}
  void greet(const Sender& from) { say(from, 0, imu::slimevr::Handshake{.protocol = 22, .mac = kMac}); }
  void turn(const Sender& from) {
    say(from, ++number_, imu::slimevr::Rotation{.data_type = 1, .xyzw = {0, 0, 0, 1}});
  }
  void answer(const Sender& from) { say(from, 0, imu::slimevr::Pong{}); }
  [[nodiscard]] Report::Link link() const {
    Report report;
    receiver_->report(now_, report);
    return report.links[0];
  }
  [[nodiscard]] int accepted_of(sensor::Peer peer) { return accepted_[peer]; }
  Receiver& receiver() { return *receiver_; }
  void wait(int ms) { now_ += std::chrono::milliseconds(ms); }

 private:
  static constexpr std::uint64_t kMac = 0x024D49454E03;
  void say(const Sender& from, std::uint64_t number, const imu::slimevr::TrackerMessage& message) {
    ByteWriter writer;
    EXPECT_TRUE(encode_tracker_message(number, message, writer));
    speaker_ = &accepted_[from.peer];
    receiver_->receive(now_, from, writer.bytes(), *this);
  }
  std::unique_ptr<Receiver> receiver_;
  std::map<sensor::Peer, int> accepted_;
  int* speaker_ = nullptr;
  HostTime now_{std::chrono::seconds(1)};
  std::uint64_t number_ = 0;
};

const Sender kBoard(1, "udp://10.0.0.1:6969");
const Sender kElsewhere(2, "udp://10.0.0.2:6969");

TEST(Receiver, ASlimeVrBoardKeepsItsPlaceAgainstItsNumberFromElsewhere) {
  SlimeVrBoards boards;
  boards.greet(kBoard);
  const auto play = [&](int packets) {
    for (int i = 0; i < packets; ++i) {
      boards.wait(10);
      boards.turn(kBoard);
      if (i == 10) boards.greet(kElsewhere);
      boards.turn(kElsewhere);
    }
  };
  play(300);
  EXPECT_EQ(boards.accepted_of(1), 300);
  EXPECT_EQ(boards.accepted_of(2), 0);
  EXPECT_EQ(boards.link().source, kBoard.source);
  ASSERT_EQ(boards.link().rivals.size(), 1u);
  EXPECT_EQ(boards.link().rivals[0].source, kElsewhere.source);
  ASSERT_TRUE(boards.receiver().hear(0, kElsewhere.source, boards));
  play(5);
  EXPECT_EQ(boards.accepted_of(2), 5);
  EXPECT_EQ(boards.accepted_of(1), 300);
}

TEST(Receiver, ASlimeVrBoardThatLiesStillAndAnswersKeepsItsPlaceForFiveSeconds) {
  SlimeVrBoards boards;
  boards.greet(kBoard);
  boards.turn(kBoard);
  boards.greet(kElsewhere);
  for (int ms = 0; ms < 4900; ms += 100) {
    boards.wait(100);
    boards.answer(kBoard);
    boards.turn(kElsewhere);
  }
  EXPECT_EQ(boards.accepted_of(2), 0);
  boards.wait(200);
  boards.answer(kBoard);  // Who never gives a reading keeps no sensor out.
  boards.turn(kElsewhere);
  EXPECT_EQ(boards.accepted_of(2), 1);
}

TEST(Receiver, ASlimeVrBoardThatComesBackAtAnotherAddressIsHeardAfterASecond) {
  SlimeVrBoards boards;
  boards.greet(kBoard);
  for (int i = 0; i < 100; ++i) {
    boards.wait(10);
    boards.turn(kBoard);
  }
  boards.wait(500);
  boards.greet(kElsewhere);
  for (int i = 0; i < 100; ++i) {
    boards.wait(10);
    boards.turn(kElsewhere);
  }
  EXPECT_GT(boards.accepted_of(2), 45);
  EXPECT_EQ(boards.link().source, kElsewhere.source);
  EXPECT_TRUE(boards.link().rivals.empty());
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

TEST(Receiver, NamesVersionsThatItDoesNotKnowOfWhomeverTheyAre) {
  std::vector<std::unique_ptr<sensor::Protocol>> protocols;
  protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  protocols.push_back(std::make_unique<phone::LiveLinkProtocol>());
  const auto receiver = Receiver::create(virt::test::three_sensors(), std::move(protocols)).value();
  const virt::VirtualSession performed = test::performance(1);
  Received received;
  const auto hear = [&](Sender sender, std::span<const std::byte> bytes) {
    return receiver->receive(performed.entries.front().arrival, sender, bytes, received).verdict;
  };
  std::vector<std::byte> packet = performed.entries.front().bytes;
  EXPECT_EQ(hear({1, "a board"}, packet), sensor::Verdict::taken);
  EXPECT_EQ(hear({2, "a phone"}, phone::test::live_link_bytes({})), sensor::Verdict::taken);
  Report report;
  receiver->report(performed.entries.front().arrival, report);
  EXPECT_TRUE(report.unknown_versions.empty());
  packet[4] = std::byte{9};
  for (int i = 0; i < 3; ++i) EXPECT_NE(hear({1, "a board"}, packet), sensor::Verdict::taken);
  for (std::uint8_t version = 7; version < 30; ++version)
    EXPECT_EQ(hear({2, "a phone"}, phone::test::live_link_bytes({.version = version})),
              sensor::Verdict::ignored);
  receiver->report(performed.entries.front().arrival, report);
  ASSERT_EQ(report.unknown_versions.size(), 8u) << "a stranger may invent more";
  EXPECT_EQ(report.unknown_versions[0].protocol, "mien");
  EXPECT_EQ(report.unknown_versions[0].version, 9u);
  EXPECT_EQ(report.unknown_versions[0].source, "a board");
  EXPECT_EQ(report.unknown_versions[0].count, 3u);
  EXPECT_EQ(report.unknown_versions[1].protocol, "livelink");
  EXPECT_EQ(report.unknown_versions[1].version, 7u);
}

}  // namespace
}  // namespace mien::session::receiver_test
