#include "mien/mocap/marker_protocol.h"

#include <gtest/gtest.h>

#include "mien/mocap/marker_packet.h"

namespace mien::mocap::marker_protocol_test {
namespace {

MarkerPositionsPacket one() {
  MarkerPositionsPacket packet;
  packet.device = 7;
  packet.count = 1;
  return packet;
}

TEST(MarkerProtocol, MarkersAreLoggedAndGiveNobodyAReading) {
  MarkerProtocol protocol;
  sensor::Inbox inbox;
  const auto bytes = encode_marker_positions(one());
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(protocol.recognises(*bytes));
  EXPECT_EQ(protocol.receive({}, 1, *bytes, inbox), sensor::Verdict::ignored);
  EXPECT_TRUE(inbox.readings.empty() && inbox.announcements.empty() && inbox.pulses.empty() && !inbox.alive);
}

TEST(MarkerProtocol, DamageIsMalformed) {
  MarkerProtocol protocol;
  sensor::Inbox inbox;
  auto bytes = encode_marker_positions(one());
  ASSERT_TRUE(bytes);
  bytes->back() ^= std::byte{1};
  EXPECT_TRUE(protocol.recognises(*bytes));
  EXPECT_EQ(protocol.receive({}, 1, *bytes, inbox), sensor::Verdict::malformed);
  EXPECT_FALSE(protocol.recognises(std::span(*bytes).first(5)));
}

}  // namespace
}  // namespace mien::mocap::marker_protocol_test
