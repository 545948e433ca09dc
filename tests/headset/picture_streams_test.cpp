#include "mien/headset/picture_streams.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "mien/headset/picture_packet.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::picture_streams_test {
namespace {

using namespace test;
using ::testing::HasSubstr;

constexpr sensor::DeviceKey kCamera{.device = 0x024D49484401, .channel = 2};

struct Got {
  PicturePacket packet;
  Bytes jpeg;
};

class Streams : public ::testing::Test {
 protected:
  Result<void> read(sensor::PayloadStream& stream, std::span<const std::byte> bytes,
                    std::size_t piece = 1460) {
    while (!bytes.empty()) {
      const auto some = bytes.first(std::min(piece, bytes.size()));
      bytes = bytes.subspan(some.size());
      MIEN_TRY(stream.read(some, [this](auto datagram, auto payload) {
        const auto packet = parse_picture_packet(datagram);
        ASSERT_TRUE(packet);
        got.push_back({*packet, {payload.begin(), payload.end()}});
      }));
    }
    return {};
  }
  std::vector<Got> got;
  const Bytes jpeg = grey_jpeg(40, 40, 1);
};

std::string head(std::string_view more = "") {
  return fmt::format("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=b\r\n{}\r\n", more);
}

std::string part(int number) {
  return fmt::format("\r\n--b\r\nContent-Type: image/jpeg\r\nX-Timestamp: {}.000000\r\n\r\n", number);
}

/// As the boards' web server puts it into chunks: each thing that is sent is one.
void add_chunk(Bytes& to, std::span<const std::byte> content) {
  to += std::string_view(fmt::format("{:x}\r\n", content.size()));
  to += content;
  to += "\r\n";
}

TEST_F(Streams, OfACameraGiveNumberedPictures) {
  Bytes plain = text_bytes(head());
  Bytes chunked = text_bytes(head("Transfer-Encoding: chunked\r\n"));
  for (int i = 0; i < 3; ++i) {
    plain += part(i);
    plain += jpeg;
    add_chunk(chunked, text_bytes(part(i)));
    add_chunk(chunked, jpeg);
  }
  for (const Bytes& sent : {plain, chunked})
    for (const std::size_t piece : {1, 17, 100'000}) {
      got.clear();
      MjpegStream stream(kCamera);
      ASSERT_TRUE(read(stream, sent, piece));
      ASSERT_EQ(got.size(), 3u);
      for (std::uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(got[i].jpeg, jpeg);
        EXPECT_EQ(got[i].packet, (PicturePacket{.from = kCamera,
                                                .sequence = i,
                                                .time = DeviceTime(std::chrono::seconds(i)),
                                                .first = i == 0}));
      }
    }
}

TEST_F(Streams, AChunkMayEndAnywhere) {
  Bytes body = text_bytes(part(1));
  body += jpeg;
  for (std::size_t cut = 1; cut < body.size(); ++cut) {
    Bytes sent = text_bytes(head("Transfer-Encoding: chunked\r\n"));
    add_chunk(sent, std::span(body).first(cut));
    add_chunk(sent, std::span(body).subspan(cut));
    MjpegStream stream(kCamera);
    got.clear();
    ASSERT_TRUE(read(stream, sent));
    ASSERT_EQ(got.size(), 1u) << cut;
    EXPECT_EQ(got[0].jpeg, jpeg);
  }
}

TEST_F(Streams, ThatBeginAnewGoOnCounting) {
  MjpegStream stream(kCamera);
  for (int i = 0; i < 2; ++i) {
    stream.restart();
    Bytes sent = text_bytes(head());
    sent += part(5);
    sent += jpeg;
    sent += jpeg;
    sent += std::span(jpeg).first(jpeg.size() / 2);
    ASSERT_TRUE(read(stream, sent));
  }
  ASSERT_EQ(got.size(), 4u);
  EXPECT_TRUE(got[0].packet.first && got[2].packet.first);
  EXPECT_FALSE(got[1].packet.first || got[3].packet.first);
  EXPECT_EQ(got[1].packet.time, std::nullopt);
  EXPECT_EQ(got[2].packet.sequence, 3u) << "the broken one has its number";
  EXPECT_EQ(stream.counts(), (sensor::StreamCounts{.whole = 4, .broken = 1}));
}

TEST_F(Streams, EndWithTheReason) {
  const auto message = [&](const std::string& text) {
    MjpegStream stream(kCamera);
    const auto result = read(stream, text_bytes(text), 7);
    return result ? std::string("none") : result.error().message();
  };
  EXPECT_THAT(message("HTTP/1.1 401 Unauthorized\r\n\r\n"), HasSubstr("password"));
  EXPECT_THAT(message("HTTP/1.1 302 Found\nLocation: /\n\n"), HasSubstr("redirects"));
  EXPECT_THAT(message(head("Transfer-Encoding: chunked\r\n") + "oops\r\n"), HasSubstr("chunk"));
  EXPECT_THAT(message(head("Transfer-Encoding: chunked\r\n") + "0\r\n\r\n"), HasSubstr("ended its stream"));
  EXPECT_THAT(message(std::string(9000, 'x')), HasSubstr("8192"));
  EXPECT_EQ(message("HTTP/1.1 200 OK\r\n"), "none") << "its head is not over";
}

TEST_F(Streams, OfASerialLineHaveNoTimes) {
  EtvrStream stream(kCamera);
  stream.restart();
  Bytes sent = {std::byte{0xFF},
                std::byte{0xA0},
                std::byte{0xFF},
                std::byte{0xA1},
                static_cast<std::byte>(jpeg.size()),
                static_cast<std::byte>(jpeg.size() >> 8U)};
  sent += jpeg;
  ASSERT_TRUE(read(stream, sent));
  ASSERT_TRUE(read(stream, sent));
  ASSERT_EQ(got.size(), 2u);
  EXPECT_EQ(got[0].packet, (PicturePacket{.from = kCamera, .sequence = 0, .time = {}, .first = true}));
  EXPECT_EQ(got[1].packet, (PicturePacket{.from = kCamera, .sequence = 1, .time = {}, .first = false}));
  EXPECT_EQ(got[1].jpeg, jpeg);
  EXPECT_EQ(stream.counts(), sensor::StreamCounts{.whole = 2});
}

TEST_F(Streams, LetNothingThroughThatNoSessionDecodes) {
  Bytes progressive = jpeg;
  progressive.at(place_of(jpeg, 0xC0) + 1) = std::byte{0xC2};
  Bytes wide = jpeg;
  wide.at(place_of(jpeg, 0xC0) + 7) = std::byte{0xFF};
  Bytes sent = text_bytes(head());
  for (const Bytes& one : {progressive, jpeg, wide, progressive, jpeg}) sent += one;
  MjpegStream stream(kCamera);
  ASSERT_TRUE(read(stream, sent));
  ASSERT_EQ(got.size(), 2u);
  EXPECT_EQ(got[1].packet.sequence, 4u) << "those that were refused have their numbers";
  EXPECT_EQ(stream.counts(), (sensor::StreamCounts{.whole = 2, .refused = 3}));
  EXPECT_EQ(stream.refusals(), (std::vector<sensor::Refusal>{{.why = "progressive", .count = 2},
                                                             {.why = "too large", .count = 1}}));
}

TEST_F(Streams, APictureWithoutAnyIsBroken) {
  MjpegStream http(kCamera);
  Bytes sent = text_bytes(head());
  sent += "\xFF\xD8\xFF\xD9";
  sent += jpeg;
  ASSERT_TRUE(read(http, sent));
  EXPECT_EQ(http.counts(), (sensor::StreamCounts{.whole = 1, .broken = 1}));
  EtvrStream line(kCamera);
  const std::array frame = {std::byte{0xFF}, std::byte{0xA0}, std::byte{0xFF}, std::byte{0xA1},
                            std::byte{4},    std::byte{0},    std::byte{0xFF}, std::byte{0xD8},
                            std::byte{0xFF}, std::byte{0xD9}};
  ASSERT_TRUE(read(line, frame));
  EXPECT_EQ(line.counts(), (sensor::StreamCounts{.broken = 1}));
  EXPECT_EQ(got.size(), 1u);
}

TEST_F(Streams, AllocateNothingOnTheWay) {
  MjpegStream stream(kCamera);
  Bytes sent = text_bytes(head());
  ASSERT_TRUE(read(stream, sent));
  Bytes body = text_bytes(part(1));
  body += jpeg;
  int pictures = 0;
  const sensor::PayloadStream::OnPayload count = [&](auto, auto) { ++pictures; };
  ASSERT_TRUE(stream.read(body, count));
  const std::size_t before = mien::test::allocation_count();
  for (int i = 0; i < 50; ++i) static_cast<void>(stream.read(body, count));
  EXPECT_EQ(mien::test::allocation_count(), before);
  EXPECT_EQ(pictures, 51);
}

}  // namespace
}  // namespace mien::headset::picture_streams_test
