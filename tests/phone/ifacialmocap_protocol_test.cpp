#include "mien/phone/ifacialmocap.h"

#include <gtest/gtest.h>

#include <string_view>

namespace mien::phone::test::ifacialmocap_protocol_test {
namespace {

using sensor::Verdict;

TEST(IFacialMocapProtocol, FramesAreSamplesAtTimesOfTheirArrivals) {
  IFacialMocapProtocol protocol;
  sensor::Inbox inbox;
  DeviceTime before{Duration::min()};
  for (int i = 0; i < 200; ++i) {
    inbox.clear();
    const std::string_view text = "trackingStatus&1|jawOpen&50|=head#0,0,0,0,0,0|";
    const HostTime arrival(std::chrono::milliseconds(33 * i + (i % 3)));
    ASSERT_EQ(protocol.receive(arrival, 4, std::as_bytes(std::span(text)), inbox), Verdict::taken);
    ASSERT_FALSE(inbox.readings.empty());
    ToldFace face;
    for (const sensor::Reading& reading : inbox.readings) {
      EXPECT_EQ(reading.from.device, kIFacialMocapDevice);
      EXPECT_TRUE(reading.sample.time_estimated);
      EXPECT_EQ(reading.sample.sequence, static_cast<std::uint32_t>(i + 1));
      EXPECT_TRUE(add_sample(reading.sample, face));
    }
    EXPECT_EQ(face.told(), 1U);
    EXPECT_GT(inbox.readings[0].sample.time, before);
    if (i > 150) {
      EXPECT_NEAR(to_seconds(inbox.readings[0].sample.time - before), 0.033, 0.003);
    }
    before = inbox.readings[0].sample.time;
  }
}

TEST(IFacialMocapProtocol, WhoSeesNoFaceIsThereAndDamageIsRefused) {
  IFacialMocapProtocol protocol;
  sensor::Inbox inbox;
  const auto hear = [&](std::string_view text) {
    inbox.clear();
    return protocol.receive({}, 1, std::as_bytes(std::span(text)), inbox);
  };
  EXPECT_EQ(hear("trackingStatus&0|jawOpen&50|"), Verdict::taken);
  EXPECT_TRUE(inbox.readings.empty());
  EXPECT_EQ(inbox.alive, (sensor::DeviceKey{kIFacialMocapDevice, 0}));
  EXPECT_EQ(inbox.no_face, inbox.alive);
  EXPECT_EQ(hear("jawOpen&50|=head#1|"), Verdict::malformed);
  EXPECT_FALSE(inbox.alive);
  EXPECT_FALSE(inbox.no_face);
}

}  // namespace
}  // namespace mien::phone::test::ifacialmocap_protocol_test
