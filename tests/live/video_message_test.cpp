#include "mien/live/video_message.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/hex.h"

namespace mien::live::video_message_test {
namespace {

/// The vector of docs/reference/page_protocol.md: the first chunk of a WebM, a second after its first frame.
const char* const kFirst = "4d564944 01 01 0000 00000000 ec030000 1a45dfa39f428681";

std::vector<std::byte> first_chunk() {
  return bytes_of(kFirst);
}

TEST(VideoMessage, IsReadAsItIsWritten) {
  const std::vector<std::byte> bytes = first_chunk();
  const auto message = parse_video_message(bytes);
  ASSERT_TRUE(message) << message.error().message();
  EXPECT_EQ(message->container, VideoContainer::webm);
  EXPECT_EQ(message->sequence, 0U);
  EXPECT_EQ(message->age_ms, 1004U);
  EXPECT_EQ(message->data.size(), 8U);
  EXPECT_EQ(encode_video_message(*message), bytes);
}

TEST(VideoMessage, RefusesWhatIsNotLaidOutSo) {
  const auto code_of = [](std::vector<std::byte> bytes) {
    const auto message = parse_video_message(bytes);
    return message ? ErrorCode::internal : message.error().code;
  };
  const auto with = [](std::size_t at, int value) {
    std::vector<std::byte> bytes = first_chunk();
    bytes.at(at) = static_cast<std::byte>(value);
    return bytes;
  };
  const std::vector<std::byte> good = first_chunk();
  for (std::size_t size = 0; size <= kVideoHeadBytes; ++size)
    EXPECT_EQ(code_of({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}),
              ErrorCode::truncated);
  EXPECT_EQ(code_of(with(0, 'N')), ErrorCode::malformed) << "magic";
  EXPECT_EQ(code_of(with(4, 2)), ErrorCode::unsupported) << "version";
  EXPECT_EQ(code_of(with(5, 0)), ErrorCode::unsupported) << "container";
  EXPECT_EQ(code_of(with(5, 3)), ErrorCode::unsupported) << "container";
  EXPECT_EQ(code_of(with(6, 1)), ErrorCode::malformed) << "reserved";
  EXPECT_EQ(code_of(with(7, 1)), ErrorCode::malformed) << "reserved";
  EXPECT_EQ(code_of(with(16, 0)), ErrorCode::malformed) << "a file that begins otherwise";
  EXPECT_EQ(code_of(with(5, 2)), ErrorCode::malformed) << "an MP4 that begins as WebM";
  EXPECT_TRUE(parse_video_message(with(8, 1))) << "of a later chunk nothing is known";
  std::vector<std::byte> longest = with(8, 1);
  longest.resize(kVideoHeadBytes + kMaxVideoChunk);
  EXPECT_TRUE(parse_video_message(longest));
  longest.push_back(std::byte{0});
  EXPECT_EQ(code_of(longest), ErrorCode::out_of_range);
}

TEST(VideoMessage, KnowsHowContainersBegin) {
  VideoMessage mp4{.container = VideoContainer::mp4, .sequence = 0, .age_ms = 0, .data = {}};
  const std::vector<std::byte> begins = bytes_of("00000020667479706d703432");
  mp4.data = begins;
  const auto whole = encode_video_message(mp4);
  EXPECT_TRUE(parse_video_message(whole));
  for (const std::size_t size : {1U, 4U, 6U}) {
    const auto cut = std::span(whole).first(kVideoHeadBytes + size);
    EXPECT_TRUE(parse_video_message(cut)) << "as far as there is something of it: " << size;
  }
  EXPECT_TRUE(is_video_message(whole));
  EXPECT_FALSE(is_video_message(std::span(whole).first(3)));
}

}  // namespace
}  // namespace mien::live::video_message_test
