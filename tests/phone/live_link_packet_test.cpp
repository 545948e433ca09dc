#include "mien/phone/live_link.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "mien/core/bytes.h"
#include "tests/phone/live_link_bytes.h"

namespace mien::phone::test::live_link_packet_test {
namespace {

TEST(LiveLinkPacket, IsReadAsThePublishedVectorHasIt) {
  // docs/reference/sinks.md: jawOpen 0.5, tongueOut 1, frame 100 at 60/1.
  std::array<float, face::kLiveLinkValueCount> values{};
  values[17] = 0.5F;
  values[51] = 1;
  const auto bytes = live_link_bytes({.values = values});
  ASSERT_EQ(bytes.size(), 310U);
  ASSERT_TRUE(is_live_link(bytes));
  const auto packet = parse_live_link(bytes).value();
  EXPECT_EQ(packet.device_id, "00000000-0000-0000-0000-000000000001");
  EXPECT_EQ(packet.subject, "face");
  EXPECT_EQ(packet.frame, 100U);
  EXPECT_EQ(packet.rate_numerator, 60U);
  EXPECT_EQ(packet.values, values);
  EXPECT_EQ(packet.time(), DeviceTime(from_seconds(100.0 / 60)));

  const ToldFace face = told_face(*packet.values);
  EXPECT_TRUE(is_sound(face));
  EXPECT_EQ(shape_name(face.set, 17), "jawOpen");
  EXPECT_EQ(face.weights[17], 0.5F);
  EXPECT_EQ(shape_name(face.set, 51), "tongueOut");
  EXPECT_EQ(face.weights[51], 1);
  EXPECT_EQ(face.told(), 52U);
}

TEST(LiveLinkPacket, TimesAreItsFramesAtItsRate) {
  const LiveLinkPacket ntsc{
      .frame = 24'000, .sub_frame = 0.5F, .rate_numerator = 24'000, .rate_denominator = 1001};
  EXPECT_NEAR(to_seconds(ntsc.time().time_since_epoch()), 24'000.5 * 1001 / 24'000, 1e-8);
}

TEST(LiveLinkPacket, WithoutValuesThereIsNoFace) {
  for (const bool counted : {false, true}) {
    const auto packet = parse_live_link(live_link_bytes({.values = {}, .counts_none = counted}));
    ASSERT_TRUE(packet) << packet.error().message();
    EXPECT_FALSE(packet->values);
  }
}

TEST(LiveLinkPacket, WeightsBeyondTheirRangeAreHeldToItAndHeadsTurn) {
  std::array<float, face::kLiveLinkValueCount> values{};
  values[17] = -0.75F;
  values[18] = 1.25F;
  values[52] = 0.4F;
  const ToldFace face = told_face(*parse_live_link(live_link_bytes({.values = values}))->values);
  EXPECT_TRUE(is_sound(face));
  EXPECT_EQ(face.weights[17], 0);
  EXPECT_EQ(face.weights[18], 1);
  ASSERT_TRUE(face.head);
  const auto& q = face.head->rotation;
  EXPECT_NEAR(2 * std::acos(q[0]), 0.4, 1e-3);
}

TEST(LiveLinkPacket, CutAnywhereItIsRefusedButWhereThereIsNoFace) {
  const auto bytes = live_link_bytes({.values = std::array<float, face::kLiveLinkValueCount>{}});
  const std::size_t header = bytes.size() - 1 - 4 * face::kLiveLinkValueCount, names = header - 16;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto packet = parse_live_link(std::span(bytes).first(size));
    EXPECT_EQ(packet.has_value(), size >= names && size <= header) << size;
    if (!packet) continue;
    EXPECT_EQ(packet->timed, size == header) << size;
    EXPECT_FALSE(packet->values) << size;
  }
}

TEST(LiveLinkPacket, ATimeBeyondWhatAnyDeviceHasIsRefused) {
  LiveLinkFields fields{.frame = 2'147'483'647, .rate = {1, 1}};
  EXPECT_EQ(parse_live_link(live_link_bytes(fields)).error().code, ErrorCode::out_of_range);
  fields.rate = {60, 1};
  EXPECT_TRUE(parse_live_link(live_link_bytes(fields)));
}

TEST(LiveLinkPacket, DamageIsRefusedWithAReason) {
  const auto code = [](const LiveLinkFields& fields) {
    return parse_live_link(live_link_bytes(fields)).error().code;
  };
  std::array<float, face::kLiveLinkValueCount> values{};
  EXPECT_EQ(code({.version = 5, .values = values}), ErrorCode::unsupported);
  EXPECT_EQ(code({.frame = -1, .values = values}), ErrorCode::out_of_range);
  EXPECT_EQ(code({.sub_frame = 1.5F, .values = values}), ErrorCode::out_of_range);
  EXPECT_EQ(code({.rate = {0, 1}, .values = values}), ErrorCode::out_of_range);
  EXPECT_EQ(code({.rate = {60, 0}, .values = values}), ErrorCode::out_of_range);
  EXPECT_EQ(code({.rate = {-60, -1}, .values = values}), ErrorCode::out_of_range);
  EXPECT_EQ(code({.subject = std::string(256, 'x'), .values = values}), ErrorCode::malformed);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 101.0F}) {
    values[3] = bad;
    EXPECT_EQ(code({.values = values}), ErrorCode::out_of_range) << bad;
  }
  auto longer = live_link_bytes({.values = std::array<float, face::kLiveLinkValueCount>{}});
  longer.push_back(std::byte{0});
  EXPECT_EQ(parse_live_link(longer).error().code, ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::phone::test::live_link_packet_test
