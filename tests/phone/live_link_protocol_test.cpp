#include "mien/phone/live_link.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/random.h"
#include "tests/phone/live_link_bytes.h"

namespace mien::phone::test::live_link_protocol_test {
namespace {

using sensor::Verdict;

HostTime at(double s) {
  return HostTime(from_seconds(s));
}

/// What a frame brought, by a protocol that goes on.
class Heard {
 public:
  Verdict hear(const LiveLinkFields& fields, double arrival_s = 0, sensor::Peer peer = 1) {
    inbox.clear();
    return protocol.receive(at(arrival_s), peer, live_link_bytes(fields), inbox);
  }
  [[nodiscard]] std::uint32_t sequence() const { return inbox.readings.at(0).sample.sequence; }

  LiveLinkProtocol protocol;
  sensor::Inbox inbox;
};

LiveLinkFields frame(std::int32_t number, const std::string& id = "phone") {
  LiveLinkFields fields{.device_id = id, .frame = number};
  fields.values.emplace().fill(0.25F);
  return fields;
}

TEST(LiveLinkProtocol, AFrameIsSamplesOfItsOwnTime) {
  Heard heard;
  ASSERT_EQ(heard.hear(frame(600)), Verdict::taken);
  ToldFace face;
  for (const sensor::Reading& reading : heard.inbox.readings) {
    EXPECT_EQ(reading.from.device, kLiveLinkDevice);
    EXPECT_EQ(reading.sample.time, DeviceTime(from_seconds(10)));
    EXPECT_FALSE(reading.sample.time_estimated);
    EXPECT_TRUE(add_sample(reading.sample, face));
  }
  EXPECT_EQ(face.told(), 52U);
  EXPECT_TRUE(face.head);
  EXPECT_EQ(face.origin, Origin::untold);
}

TEST(LiveLinkProtocol, CountsFramesThatThePhoneMade) {
  // Rates of phones, counted in sixtieths and in their own; each frame is one, and a tenth are lost.
  for (const double rate_hz : {23.976, 24.0, 25.0, 30.0, 60.0})
    for (const double count_hz : {60.0, rate_hz}) {
      Heard heard;
      Random random(3);
      std::uint32_t first = 0;
      int lost = 0;
      for (int n = 0; n < 600; ++n) {
        if (n > 30 && n < 599 && random.chance(0.1)) {
          ++lost;
          continue;
        }
        heard.hear(frame(10'000 + static_cast<std::int32_t>(std::floor(n * count_hz / rate_hz))));
        if (n == 30) first = heard.sequence();
      }
      EXPECT_GT(lost, 30);
      EXPECT_EQ(heard.sequence() - first, 569U) << rate_hz << " in " << count_hz;
    }
}

TEST(LiveLinkProtocol, WhatComesLateOrTwiceIsCountedSo) {
  Heard heard;
  for (int i = 0; i < 20; ++i) heard.hear(frame(1000 + 2 * i));
  const std::uint32_t before = heard.sequence();
  heard.hear(frame(1040));
  EXPECT_EQ(heard.sequence(), before + 1);
  heard.hear(frame(1046));  // Two are lost.
  EXPECT_EQ(heard.sequence(), before + 4);
  heard.hear(frame(1044));  // One of them comes late.
  EXPECT_EQ(heard.sequence(), before + 3);
  heard.hear(frame(1044));  // Twice.
  EXPECT_EQ(heard.sequence(), before + 3);
  heard.hear(frame(1045));  // One early frame.
  heard.hear(frame(1048));
  const std::uint32_t then = heard.sequence();
  heard.hear(frame(1050));
  EXPECT_EQ(heard.sequence(), then + 1);
}

TEST(LiveLinkProtocol, WithoutAFaceThePhoneIsThere) {
  Heard heard;
  heard.hear(frame(1));
  EXPECT_FALSE(heard.inbox.no_face);
  ASSERT_EQ(heard.hear({.device_id = "phone", .frame = 2}), Verdict::taken);
  EXPECT_TRUE(heard.inbox.readings.empty());
  ASSERT_TRUE(heard.inbox.alive);
  EXPECT_EQ(heard.inbox.alive->device, kLiveLinkDevice);
  EXPECT_EQ(heard.inbox.no_face, heard.inbox.alive);
}

TEST(LiveLinkProtocol, FramesWithoutAFaceAreNotLost) {
  Heard heard;
  for (int i = 0; i < 20; ++i) heard.hear(frame(1000 + i));
  const std::uint32_t before = heard.sequence();
  for (int i = 20; i < 260; ++i)
    if (i != 100) heard.hear({.device_id = "phone", .frame = 1000 + i});
  heard.hear(frame(1260));
  EXPECT_EQ(heard.sequence(), before + 2) << "one of them never came";
}

TEST(LiveLinkProtocol, APhoneIsKnownByItsIdWhateverItIsCalledAndWhereverItSendsFrom) {
  Heard heard;
  heard.hear(frame(1));
  heard.hear(frame(1, "another"), 0, 2);
  EXPECT_EQ(heard.inbox.readings.at(0).from.device, kLiveLinkDevice + 1);
  LiveLinkFields renamed = frame(2);
  renamed.subject = "renamed";
  heard.hear(renamed, 0, 3);
  EXPECT_EQ(heard.inbox.readings.at(0).from.device, kLiveLinkDevice);
}

TEST(LiveLinkProtocol, WhoIsNewTakesThePlaceOfTheOneSilentForLongest) {
  Heard heard;
  for (std::size_t i = 0; i < kMostLiveLinkPhones; ++i)
    ASSERT_EQ(heard.hear(frame(1, "phone " + std::to_string(i)), 0.1 * static_cast<double>(i)),
              Verdict::taken);
  EXPECT_EQ(heard.hear(frame(1, "new"), 1.9), Verdict::ignored);
  EXPECT_EQ(heard.hear(frame(1, "phone 0"), 2.0), Verdict::taken);
  ASSERT_EQ(heard.hear(frame(1, "new"), 3.0), Verdict::taken);
  EXPECT_EQ(heard.inbox.readings.at(0).from.device, kLiveLinkDevice + 1);
}

TEST(LiveLinkProtocol, WhatIsRefusedLeavesNoTrace) {
  Heard heard;
  heard.hear(frame(10));
  heard.hear(frame(11));
  const std::uint32_t before = heard.sequence();
  LiveLinkFields damaged = frame(5000);
  damaged.sub_frame = -1;
  EXPECT_EQ(heard.hear(damaged), Verdict::malformed);
  LiveLinkFields newer = frame(5000);
  newer.version = 7;
  EXPECT_EQ(heard.hear(newer), Verdict::ignored);
  EXPECT_TRUE(heard.inbox.readings.empty());
  heard.hear(frame(12));
  EXPECT_EQ(heard.sequence(), before + 1);
}

}  // namespace
}  // namespace mien::phone::test::live_link_protocol_test
