#include "mien/phone/weights_protocol.h"

#include <gtest/gtest.h>

#include "mien/phone/packet.h"

namespace mien::phone::weights_protocol_test {
namespace {

using sensor::Verdict;

Packet whole_face() {
  Packet packet{.device = 0x024D49454E70, .sequence = 5, .battery_percent = 40};
  packet.time = DeviceTime(std::chrono::seconds(2));
  packet.face.set = ShapeSet::unified;
  packet.face.origin = Origin::measured;
  for (std::size_t i = 0; i < kMostShapes; ++i) {
    packet.face.weights[i] = static_cast<float>(i) / kMostShapes;
    packet.face.confidence[i] = 1;
  }
  packet.face.head = ToldHead{};
  return packet;
}

TEST(WeightsProtocol, OnePacketIsSamplesOfOneSequenceAndTime) {
  const Packet packet = whole_face();
  auto bytes = encode_packet(packet).value();
  WeightsProtocol protocol;
  sensor::Inbox inbox;
  ASSERT_TRUE(protocol.recognises(bytes));
  ASSERT_EQ(protocol.receive({}, 1, bytes, inbox), Verdict::taken);
  EXPECT_EQ(inbox.readings.size(), kMostParts);
  ToldFace face;
  for (const sensor::Reading& reading : inbox.readings) {
    EXPECT_EQ(reading.from.device, packet.device);
    EXPECT_EQ(reading.sample.sequence, 5U);
    EXPECT_EQ(reading.sample.time, packet.time);
    EXPECT_FALSE(reading.sample.time_estimated);
    EXPECT_TRUE(add_sample(reading.sample, face));
  }
  EXPECT_EQ(face, packet.face);
  EXPECT_FALSE(inbox.no_face);
  EXPECT_EQ(inbox.batteries.at(0).percent, 40);
  inbox.clear();
  bytes[50] ^= std::byte{1};
  EXPECT_EQ(protocol.receive({}, 1, bytes, inbox), Verdict::malformed);
  bytes[4] = std::byte{2};
  EXPECT_EQ(protocol.receive({}, 1, bytes, inbox), Verdict::ignored);
  EXPECT_TRUE(inbox.readings.empty());
}

TEST(WeightsProtocol, WhoTellsNothingIsAlive) {
  Packet packet = whole_face();
  packet.face = {};
  WeightsProtocol protocol;
  sensor::Inbox inbox;
  ASSERT_EQ(protocol.receive({}, 1, encode_packet(packet).value(), inbox), Verdict::taken);
  EXPECT_TRUE(inbox.readings.empty());
  ASSERT_TRUE(inbox.alive);
  EXPECT_EQ(inbox.alive->device, packet.device);
  EXPECT_FALSE(inbox.no_face) << "it does not say why";
}

TEST(WeightsProtocol, WhoHoldsSeesNoFace) {
  Packet packet = whole_face();
  packet.face.origin = Origin::held;
  WeightsProtocol protocol;
  sensor::Inbox inbox;
  ASSERT_EQ(protocol.receive({}, 1, encode_packet(packet).value(), inbox), Verdict::taken);
  EXPECT_EQ(inbox.readings.size(), kMostParts);
  EXPECT_EQ(inbox.no_face, (sensor::DeviceKey{packet.device, 0}));
}

}  // namespace
}  // namespace mien::phone::weights_protocol_test
