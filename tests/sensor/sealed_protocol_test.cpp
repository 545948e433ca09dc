// The envelope of paired devices, around two toy languages.
#include "mien/sensor/sealed_protocol.h"

#include <gtest/gtest.h>

#include "mien/sensor/packet_envelope.h"
#include "tests/hex.h"

namespace mien::sensor::sealed_protocol_test {
namespace {

constexpr std::uint64_t kSession = 0x1122334455667788;
constexpr std::uint64_t kDevice = 0x024D'4945'4E07;
constexpr std::uint8_t kReadings = 30, kLevels = 31;

/// Packets of one type; it takes them, and answers with what they hold. Those that are cut are malformed.
class Language final : public Protocol {
 public:
  Language(std::uint8_t type, std::uint8_t channel) : type_(type), channel_(channel) {}
  std::string_view name() const override { return "toy"; }
  bool recognises(std::span<const std::byte> datagram) const override {
    return is_our_packet(datagram, type_) || is_our_packet(datagram, kHelloPacketType);
  }
  Verdict receive(HostTime, Peer, std::span<const std::byte> datagram, Inbox& inbox) override {
    if (datagram.size() != 17) return Verdict::malformed;
    inbox.alive = DeviceKey{std::to_integer<std::uint64_t>(datagram[16]), channel_};
    inbox.reply.assign(datagram.begin(), datagram.end());
    return Verdict::taken;
  }

 private:
  std::uint8_t type_, channel_;
};

std::vector<std::byte> packet(std::uint8_t type, std::uint64_t device = kDevice) {
  ByteWriter writer;
  write_packet_begin(type, writer);
  writer.little(std::uint16_t{0});
  writer.little(device);
  writer.little(std::uint8_t{9});
  return writer.release();
}

SealKey key(std::uint8_t id) {
  SealKey key{.id = id, .secret = {}};
  key.secret.fill(std::byte{id});
  return key;
}

class SealedProtocolTest : public ::testing::Test {
 protected:
  static SealedProtocol host(std::uint64_t session = kSession) {
    std::vector<std::unique_ptr<Protocol>> languages;
    languages.push_back(std::make_unique<Language>(kReadings, 0));
    languages.push_back(std::make_unique<Language>(kLevels, 1));
    auto made = SealedProtocol::create(session, {key(2), key(1)}, std::move(languages));
    EXPECT_TRUE(made) << made.error().message();
    return std::move(*made);
  }
  std::vector<std::byte> seal(std::span<const std::byte> inner, std::uint64_t device = kDevice,
                              std::uint64_t session = kSession, std::uint8_t id = 1) {
    ByteWriter writer;
    EXPECT_TRUE(seal_packet(
        key(id), {.key_id = id, .device = device, .counter = ++counter, .session = session}, inner, writer));
    return writer.release();
  }
  Verdict hear(SealedProtocol& by, std::span<const std::byte> datagram) {
    inbox.clear();
    const Verdict verdict = by.receive(HostTime(), 1, datagram, inbox);
    if (verdict == Verdict::refused || verdict == Verdict::malformed) {
      EXPECT_TRUE(inbox.opened.empty());
      EXPECT_TRUE(inbox.reply.empty());
      EXPECT_FALSE(inbox.alive);
    }
    return verdict;
  }
  std::uint64_t counter = 0;
  Inbox inbox;
};

TEST_F(SealedProtocolTest, HandsEachPacketToTheLanguageThatItIsOf) {
  SealedProtocol both = host();
  for (const std::uint8_t type : {kReadings, kLevels}) {
    const auto plain = packet(type);
    EXPECT_EQ(hear(both, seal(plain)), Verdict::taken);
    EXPECT_EQ(inbox.opened, plain);
    EXPECT_EQ(inbox.alive, (DeviceKey{9, type == kLevels}));
    std::vector<std::byte> reply;
    const auto header = open_sealed(std::vector{key(1)}, inbox.reply, reply);
    ASSERT_TRUE(header);
    EXPECT_EQ(reply, plain);
    EXPECT_EQ(*header, (SealHeader{.key_id = 1,
                                   .device = kDevice,
                                   .counter = SealHeader::kFromHost + (type == kLevels ? 1U : 0U),
                                   .session = kSession}));
  }
}

TEST_F(SealedProtocolTest, RefusesWhatIsNotSealedOrNotOfALanguage) {
  SealedProtocol both = host();
  EXPECT_TRUE(both.recognises(packet(kReadings)));
  EXPECT_FALSE(both.recognises(bytes_of("3132332c3435")));
  EXPECT_EQ(hear(both, packet(kReadings)), Verdict::refused);
  EXPECT_EQ(hear(both, seal(packet(77))), Verdict::refused);
  // A line of text, and a packet too short to name its device.
  EXPECT_EQ(hear(both, seal(bytes_of("3132332c34350d0a3132332c3435"))), Verdict::refused);
  auto cut = packet(kReadings);
  cut.resize(9);
  EXPECT_EQ(hear(both, seal(cut, 0)), Verdict::refused);
}

TEST_F(SealedProtocolTest, RefusesWrongKeysOtherDevicesAndSessions) {
  SealedProtocol both = host();
  EXPECT_EQ(hear(both, seal(packet(kReadings), kDevice, kSession, 3)), Verdict::refused);
  EXPECT_EQ(hear(both, seal(packet(kReadings), kDevice + 1)), Verdict::refused);
  EXPECT_EQ(hear(both, seal(packet(kReadings), kDevice, 5)), Verdict::refused);
  EXPECT_EQ(hear(both, seal(packet(kReadings), kDevice, 0)), Verdict::refused);
  EXPECT_EQ(hear(both, seal(packet(kHelloPacketType), kDevice, 0)), Verdict::taken);
}

TEST_F(SealedProtocolTest, DamageIsToldFromForgery) {
  SealedProtocol both = host();
  auto bytes = seal(packet(kLevels));
  bytes[40] ^= std::byte{1};
  EXPECT_EQ(hear(both, bytes), Verdict::malformed);
  renew_checksum(bytes);
  EXPECT_EQ(hear(both, bytes), Verdict::refused);
  bytes[40] ^= std::byte{1};
  renew_checksum(bytes);
  EXPECT_EQ(hear(both, bytes), Verdict::taken);
  // And what was damaged before it was sealed.
  auto cut = packet(kLevels);
  cut.pop_back();
  EXPECT_EQ(hear(both, seal(cut)), Verdict::malformed);
}

TEST_F(SealedProtocolTest, HearsNothingTwiceByKeyAndDevice) {
  SealedProtocol both = host();
  const auto once = seal(packet(kReadings));
  EXPECT_EQ(hear(both, once), Verdict::taken);
  EXPECT_EQ(hear(both, once), Verdict::refused);
  // Neither another device's counter nor that of the same with another key is its own.
  counter = 0;
  EXPECT_EQ(hear(both, seal(packet(kReadings, 8), 8)), Verdict::taken);
  counter = 0;
  EXPECT_EQ(hear(both, seal(packet(kReadings), kDevice, kSession, 2)), Verdict::taken);
  counter = 100;
  EXPECT_EQ(hear(both, seal(packet(kReadings))), Verdict::taken);
  counter = 101 - ReplayWindow::kWidth - 1;
  EXPECT_EQ(hear(both, seal(packet(kReadings))), Verdict::refused) << "64 behind";
  EXPECT_EQ(hear(both, seal(packet(kReadings))), Verdict::taken) << "63 behind";
  // What one session heard another does not.
  SealedProtocol next = host(5);
  EXPECT_EQ(hear(next, once), Verdict::refused);
}

TEST_F(SealedProtocolTest, IsNotMadeOfWhatProtectsNothing) {
  EXPECT_FALSE(SealedProtocol::create(kSession, {}, {}));
  EXPECT_FALSE(SealedProtocol::create(kSession, {key(1), key(2), key(1)}, {}));
  EXPECT_FALSE(SealedProtocol::create(0, {key(1)}, {}));
}

}  // namespace
}  // namespace mien::sensor::sealed_protocol_test
