#include "mien/eyewear/eyewear_protocol.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mien/core/cobs.h"
#include "mien/core/random.h"

namespace mien::eyewear::eyewear_protocol_test {
namespace {

using sensor::DeviceKey;
using sensor::Inbox;
using sensor::SampleKind;
using sensor::Verdict;

constexpr std::uint64_t kDevice = 0x024D49454E40;

EyewearProtocol make(EyewearProtocolSettings settings = {}) {
  auto made = EyewearProtocol::create(settings);
  EXPECT_TRUE(made);
  return std::move(*made);
}

Packet scan(std::uint32_t sequence = 0) {
  Packet packet;
  packet.channels = 20;
  packet.device = kDevice;
  packet.sequence = sequence;
  packet.time = DeviceTime(sequence * std::chrono::milliseconds(4));
  for (std::size_t c = 0; c < packet.channels; ++c)
    packet.light[c] = {static_cast<std::uint16_t>(500 + c), static_cast<std::uint16_t>(c)};
  return packet;
}

std::vector<std::byte> framed(const Packet& packet) {
  std::vector<std::byte> frame;
  cobs_encode(encode_packet(packet).value(), frame);
  return frame;
}

HostTime at(double seconds) {
  return HostTime(from_seconds(seconds));
}

/// A protocol with what came of each thing that it was told.
struct Host {
  EyewearProtocol protocol;
  Inbox inbox;
  double now_s = 0;
  double step_s = 0.01;  // Between two lines.

  explicit Host(EyewearProtocolSettings settings = {}) : protocol(make(settings)) {}

  Verdict receive(std::span<const std::byte> bytes, sensor::Peer peer = 0) {
    inbox.clear();
    now_s += step_s;
    EXPECT_TRUE(protocol.recognises(bytes));
    return protocol.receive(at(now_s), peer, bytes, inbox);
  }
  Verdict receive(std::string_view text, sensor::Peer peer = 0) {
    return receive(std::as_bytes(std::span(text)), peer);
  }
  /// Lines until their number of values is believed.
  void meet(std::string_view text, sensor::Peer peer = 0) {
    for (int i = 0; i < 8; ++i) EXPECT_EQ(receive(text, peer), Verdict::taken);
  }
  [[nodiscard]] float on(std::size_t channel) const { return inbox.readings.at(channel).sample.values[0]; }
  [[nodiscard]] float off(std::size_t channel) const { return inbox.readings.at(channel).sample.values[1]; }
};

TEST(EyewearProtocol, AScanGivesEveryChannelASample) {
  Packet packet = scan(7);
  packet.light[3].on = 1023;
  packet.battery_percent = 40;
  for (const auto& bytes : {encode_packet(packet).value(), framed(packet)}) {
    Host host;
    EXPECT_EQ(host.receive(bytes), Verdict::taken);
    ASSERT_EQ(host.inbox.readings.size(), 20u);
    for (std::uint8_t c = 0; c < 20; ++c) {
      const sensor::Reading& reading = host.inbox.readings[c];
      EXPECT_EQ(reading.from, (DeviceKey{kDevice, c}));
      EXPECT_EQ(reading.sample.kind, SampleKind::eyewear_light);
      EXPECT_EQ(reading.sample.sequence, 7u);
      EXPECT_EQ(reading.sample.time, packet.time);
      EXPECT_FALSE(reading.sample.time_estimated);
      EXPECT_EQ(reading.saturated, c == 3);
      EXPECT_FLOAT_EQ(host.off(c), static_cast<float>(c) / 1023);
    }
    ASSERT_EQ(host.inbox.batteries.size(), 20u);
    EXPECT_EQ(host.inbox.batteries[19].from, (DeviceKey{kDevice, 19}));
    EXPECT_EQ(host.inbox.batteries[19].percent, 40);
    EXPECT_TRUE(host.inbox.reply.empty());
  }
}

TEST(EyewearProtocol, KnowsItsOwn) {
  const EyewearProtocol protocol = make();
  const auto knows = [&](std::vector<std::byte> bytes) { return protocol.recognises(bytes); };
  const auto datagram = encode_packet(scan()).value();
  EXPECT_TRUE(knows(datagram));
  EXPECT_TRUE(knows(framed(scan())));
  auto other = datagram;
  other[5] = std::byte{1};  // An IMU node's.
  EXPECT_FALSE(knows(other));
  EXPECT_FALSE(knows({}));
  EXPECT_FALSE(knows({std::byte{0xFF}}));
  EXPECT_FALSE(knows({std::byte{0}, std::byte{0}, std::byte{0}, std::byte{3}}));  // A SlimeVR handshake's.
}

TEST(EyewearProtocol, DamagedFramesAreMalformedAndNothingElse) {
  Host host;
  const auto good = framed(scan());
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    auto frame = good;
    const std::size_t where = 7 + random.below(frame.size() - 7);
    switch (i % 3) {
      case 0:
        frame[where] ^= static_cast<std::byte>(1 + random.below(255));
        break;
      case 1:
        frame.erase(frame.begin() + static_cast<std::ptrdiff_t>(where));
        break;
      default:
        frame.insert(frame.begin() + static_cast<std::ptrdiff_t>(where), frame[where]);
    }
    if (frame == good) continue;
    EXPECT_EQ(host.receive(frame), Verdict::malformed);
    EXPECT_TRUE(host.inbox.readings.empty());
  }
  EXPECT_EQ(host.receive(good), Verdict::taken);
}

TEST(EyewearProtocol, ALaterVersionIsIgnored) {
  Host host;
  auto datagram = encode_packet(scan()).value();
  datagram[4] = std::byte{2};
  EXPECT_EQ(host.receive(datagram), Verdict::ignored);
  std::vector<std::byte> frame;
  cobs_encode(datagram, frame);
  EXPECT_EQ(host.receive(frame), Verdict::ignored);
}

TEST(EyewearProtocol, TextIsBelievedOnceEightLinesAgree) {
  Host host;
  EXPECT_EQ(host.receive("56,789\r\n"),
            Verdict::taken);  // The end of a line: the port was opened in its middle.
  EXPECT_TRUE(host.inbox.readings.empty());
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(host.receive("123,456,789\r\n"), Verdict::taken);
    EXPECT_TRUE(host.inbox.readings.empty());
    EXPECT_FALSE(host.inbox.alive);
  }
  EXPECT_EQ(host.receive("123,456,1023\r\n"), Verdict::taken);
  ASSERT_EQ(host.inbox.readings.size(), 3u);
  for (std::uint8_t c = 0; c < 3; ++c) {
    EXPECT_EQ(host.inbox.readings[c].from, (DeviceKey{kTextDevice, c}));
    EXPECT_TRUE(host.inbox.readings[c].sample.time_estimated);
    EXPECT_EQ(host.inbox.readings[c].saturated, c == 2);
    EXPECT_EQ(host.off(c), 0.0F);
  }
  EXPECT_FLOAT_EQ(host.on(0), 123.0F / 1023);
  EXPECT_EQ(host.on(2), 1.0F);
  EXPECT_EQ(sensor::format_device(host.inbox.readings[1].from), "02:4D:49:54:58:00/1");
}

TEST(EyewearProtocol, LinesOfAnotherLengthAreMalformed) {
  Host host;
  host.meet("1,2,3");
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(host.receive("1,2"), Verdict::malformed);
    EXPECT_EQ(host.receive("1,2,31,2,3"), Verdict::malformed);
    EXPECT_EQ(host.receive("1,2,3"), Verdict::taken);
    EXPECT_EQ(host.inbox.readings.size(), 3u);
  }
}

TEST(EyewearProtocol, AnotherSketchIsBelievedInTime) {
  Host host;
  host.meet("1,2,3");
  // Fifty lines, half a second: a device that loses its commas would be believed no sooner.
  int malformed = 0;
  while (host.receive("1,2,3,4") == Verdict::malformed) ++malformed;
  EXPECT_NEAR(malformed, 49, 1);
  for (int i = 0; i < 6; ++i) {
    EXPECT_TRUE(host.inbox.readings.empty());
    EXPECT_EQ(host.receive("1,2,3,4"), Verdict::taken);
  }
  EXPECT_EQ(host.receive("1,2,3,4"), Verdict::taken);
  EXPECT_EQ(host.inbox.readings.size(), 4u);
  EXPECT_EQ(host.receive("1,2,3"), Verdict::malformed);
}

TEST(EyewearProtocol, AHeaderSaysThatValuesArePairs) {
  Host host;
  host.meet("1,2,3,4");
  EXPECT_EQ(host.receive("# mien on off bits 12"), Verdict::taken);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(host.receive("4000,10,4095,4095"), Verdict::taken);
  EXPECT_TRUE(host.inbox.readings.empty());
  EXPECT_EQ(host.receive("4000,10,4095,4095"), Verdict::taken);
  ASSERT_EQ(host.inbox.readings.size(), 2u);
  EXPECT_FLOAT_EQ(host.on(0), 4000.0F / 4095);
  EXPECT_FLOAT_EQ(host.off(0), 10.0F / 4095);
  EXPECT_FALSE(host.inbox.readings[0].saturated);
  EXPECT_TRUE(host.inbox.readings[1].saturated);
  for (const char* text : {"1,2,3", "4096,1,1,1", "-1,1,1,1"}) {
    EXPECT_EQ(host.receive(text), Verdict::malformed) << text;
    EXPECT_TRUE(host.inbox.readings.empty());
  }
}

TEST(EyewearProtocol, ANegativeDifferenceKeepsItsWorth) {
  Host host;
  host.meet("-5,5,-1023");
  EXPECT_FLOAT_EQ(host.on(0) - host.off(0), -5.0F / 1023);
  EXPECT_FLOAT_EQ(host.on(1) - host.off(1), 5.0F / 1023);
  EXPECT_TRUE(host.inbox.readings[2].saturated);
  EXPECT_EQ(host.receive("-1024,1,1"), Verdict::malformed);
}

TEST(EyewearProtocol, SettingsSayTheBitsOfText) {
  Host host({.text_bits = 12});
  host.meet("4095");
  EXPECT_EQ(host.on(0), 1.0F);
  EXPECT_EQ(EyewearProtocol::create({.text_bits = 7}).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(EyewearProtocol::create({.text_bits = 17}).error().code, ErrorCode::bad_usage);
}

TEST(EyewearProtocol, EveryPlaceThatTextComesFromIsADevice) {
  Host host;
  EXPECT_EQ(host.receive("garbage", 99), Verdict::malformed);  // Makes none.
  for (sensor::Peer peer = 0; peer < kMaxTextDevices; ++peer) {
    host.meet("1", 7 + peer);
    EXPECT_EQ(host.inbox.readings.at(0).from, (DeviceKey{kTextDevice + peer, 0}));
  }
  for (int i = 0; i < 7; ++i) EXPECT_EQ(host.receive("1", 6), Verdict::taken);
  EXPECT_EQ(host.receive("1", 6), Verdict::ignored) << "all are there";
  for (sensor::Peer peer = 1; peer < kMaxTextDevices; ++peer) host.meet("1", 7 + peer);
  EXPECT_EQ(host.receive("1", 6), Verdict::ignored);
  host.now_s += 8.5;
  EXPECT_EQ(host.receive("1", 6), Verdict::taken) << "the first was silent for ten seconds";
  EXPECT_EQ(host.inbox.readings.at(0).from, (DeviceKey{kTextDevice + kMaxTextDevices, 0}))
      << "nobody else's id";
  host.now_s += 1;
  host.meet("1", 7);
  EXPECT_EQ(host.inbox.readings.at(0).from, (DeviceKey{kTextDevice, 0})) << "its own again";
}

// 300 strangers between any two lines of a sketch that prints ten a second: all that a session lets through.
TEST(EyewearProtocol, StrangersWithALineEachKeepNoDeviceOut) {
  Host host;
  host.step_s = 0.1 / 301;
  sensor::Peer stranger = 100;
  for (int line = 0; line < 8; ++line) {
    for (int i = 0; i < 300; ++i) EXPECT_EQ(host.receive("7", stranger++), Verdict::taken);
    EXPECT_EQ(host.receive("1,2", 1), Verdict::taken);
  }
  EXPECT_EQ(host.inbox.readings.size(), 2u);
}

TEST(EyewearProtocol, StrangersWhoStopShortKeepNoDeviceOut) {
  Host host;
  for (sensor::Peer stranger = 100; stranger < 620; ++stranger)
    for (int i = 0; i < 7; ++i) EXPECT_EQ(host.receive("7", stranger), Verdict::taken);
  host.now_s += 1;
  for (int line = 0; line < 8; ++line) {
    EXPECT_EQ(host.receive("7", 1000 + static_cast<sensor::Peer>(line)), Verdict::taken);
    EXPECT_EQ(host.receive("1,2", 1), Verdict::taken);
  }
  EXPECT_EQ(host.inbox.readings.size(), 2u);
}

TEST(EyewearProtocol, WhatIsNoScanIsTold) {
  Host host;
  host.meet("1,2");
  EXPECT_EQ(host.receive("# my eyewear, March"), Verdict::ignored);
  EXPECT_EQ(host.receive("rst:0x1 (POWERON_RESET)"), Verdict::malformed);
  EXPECT_EQ(host.receive("1,,2"), Verdict::malformed);
  EXPECT_EQ(host.receive("1,5000"), Verdict::malformed);
  EXPECT_EQ(host.receive("# mien off"), Verdict::malformed);
  EXPECT_EQ(host.receive("1,2"), Verdict::taken);
  EXPECT_EQ(host.inbox.readings.size(), 2u);
}

/// Root mean square of the sample times' error about their mean, ms, of 20 s after 5 s, and that of the
/// arrivals.
struct Timing {
  double clock_ms = 0;
  double arrivals_ms = 0;
};

template <class Delay>
Timing timing(double rate_hz, const Delay& arrival_of) {
  EyewearProtocol protocol = make();
  Inbox inbox;
  std::vector<double> clock;
  std::vector<double> arrivals;
  double newest_s = 0;
  for (int i = 0; i < static_cast<int>(25 * rate_hz); ++i) {
    const double truth_s = i / rate_hz;
    newest_s = std::max(newest_s, arrival_of(truth_s));
    inbox.clear();
    const std::string text = fmt::format("{},{}", i % 1000, 500);
    if (protocol.receive(at(newest_s), 0, std::as_bytes(std::span(text)), inbox) != Verdict::taken)
      ADD_FAILURE();
    if (inbox.readings.empty() || truth_s < 5) continue;
    EXPECT_EQ(inbox.readings[0].sample.time, inbox.readings[1].sample.time);
    clock.push_back(to_seconds(inbox.readings[0].sample.time.time_since_epoch()) - truth_s);
    arrivals.push_back(newest_s - truth_s);
  }
  const auto spread_ms = [](const std::vector<double>& errors) {
    double mean = 0;
    double square = 0;
    for (const double e : errors) mean += e / static_cast<double>(errors.size());
    for (const double e : errors) square += (e - mean) * (e - mean) / static_cast<double>(errors.size());
    return 1e3 * std::sqrt(square);
  };
  return {spread_ms(clock), spread_ms(arrivals)};
}

TEST(EyewearProtocol, LinesGetTheirTimeFromTheirArrivals) {
  for (const double rate_hz : {50.0, 100.0, 250.0, 500.0}) {
    // A cable that hands over every 16 ms what came, as USB converters do; and a scheduler's delays.
    const Timing batches =
        timing(rate_hz, [](double truth_s) { return std::ceil((truth_s + 0.002) / 0.016) * 0.016; });
    Random random(4);
    const Timing jitter = timing(
        rate_hz, [&](double truth_s) { return truth_s + 0.001 - 0.003 * std::log(1 - random.uniform()); });
    EXPECT_LT(batches.clock_ms, rate_hz < 400 ? 0.4 : 1.5) << rate_hz;
    EXPECT_GT(batches.arrivals_ms, 4) << rate_hz;
    EXPECT_LT(jitter.clock_ms, rate_hz < 400 ? 0.5 : 0.9) << rate_hz;
    EXPECT_GT(jitter.arrivals_ms, 2.5) << rate_hz;
  }
}

// A log keeps what was taken or ignored and nothing else: without the rest a replay decodes alike.
TEST(EyewearProtocol, WhatIsMalformedLeavesNoTrace) {
  const auto run = [](bool with_malformed) {
    Host host;
    std::vector<std::pair<DeviceTime, std::uint32_t>> said;
    std::vector<std::pair<double, std::string>> log;
    Random random(9);
    for (int i = 0; i < 600; ++i) {
      host.now_s += 0.003 * random.uniform();
      const std::string text = i == 300     ? "# mien bits 12"
                               : i % 7 == 3 ? "1,2,3,,"
                               : i % 5 == 4 ? "1,2"
                                            : "1,2,3";
      log.emplace_back(host.now_s, text);
    }
    EyewearProtocol first = make();
    EyewearProtocol second = make();
    for (const auto& [now_s, text] : log) {
      host.inbox.clear();
      const auto bytes = std::as_bytes(std::span(text));
      const Verdict verdict = first.receive(at(now_s), 0, bytes, host.inbox);
      if (!with_malformed) {
        host.inbox.clear();
        if (verdict == Verdict::malformed) continue;
        EXPECT_EQ(second.receive(at(now_s), 0, bytes, host.inbox), verdict);
      }
      for (const auto& reading : host.inbox.readings)
        said.emplace_back(reading.sample.time, reading.sample.sequence);
    }
    EXPECT_GT(said.size(), 900u);
    return said;
  };
  EXPECT_EQ(run(true), run(false));
}

}  // namespace
}  // namespace mien::eyewear::eyewear_protocol_test
