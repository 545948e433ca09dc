#include "mien/speech/sound_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hex.h"

namespace mien::speech::sound_message_test {
namespace {

using ::testing::HasSubstr;

const SoundMessage kMessage = {.rate_hz = 48'000, .count = 960, .samples = {1, -2, 32767}};

std::vector<std::byte> with(std::size_t place, int value) {
  std::vector<std::byte> bytes = encode_message(kMessage);
  bytes[place] = static_cast<std::byte>(value);
  return bytes;
}

TEST(SoundMessage, HasTheLayoutOfThePagesProtocol) {
  const std::vector<std::byte> bytes = encode_message(kMessage);
  EXPECT_EQ(bytes, mien::bytes_of("4d534e440100000080bb0000c0030000000000000100feffff7f"));
  const auto read = parse_message(bytes);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, kMessage);
}

TEST(SoundMessage, IsOfAnyRateAndATenthOfASecondAtMost) {
  for (const int rate_hz : {kLowestRateHz, 11'025, 44'100, kHighestRateHz}) {
    SoundMessage longest{.rate_hz = rate_hz, .count = kMostSamples - 1, .samples = {}};
    longest.samples.resize(static_cast<std::size_t>(rate_hz / kMessagesPerSecond), -32'768);
    EXPECT_EQ(parse_message(encode_message(longest)).value(), longest);
    longest.samples.push_back(0);
    const auto refused = parse_message(encode_message(longest));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::malformed);
    EXPECT_THAT(refused.error().message(), HasSubstr("tenth of a second"));
  }
}

TEST(SoundMessage, RefusesEachWrongThingAlone) {
  const std::vector<std::byte> bytes = encode_message(kMessage);
  for (std::size_t length = 0; length < kMessageHeadBytes + 2; ++length)
    EXPECT_EQ(parse_message(std::span(bytes).first(length)).error().code, ErrorCode::truncated) << length;
  EXPECT_EQ(parse_message(std::span(bytes).first(bytes.size() - 1)).error().code, ErrorCode::malformed);
  for (std::size_t place = 0; place < 4; ++place)
    EXPECT_EQ(parse_message(with(place, 'x')).error().code, ErrorCode::malformed) << place;
  EXPECT_EQ(parse_message(with(4, 2)).error().code, ErrorCode::unsupported);
  for (std::size_t place = 5; place < 8; ++place)
    EXPECT_EQ(parse_message(with(place, 1)).error().code, ErrorCode::malformed) << place;
  for (const int rate_hz : {0, 7'999, 192'001, -1}) {
    SoundMessage odd = kMessage;
    odd.rate_hz = rate_hz;
    const auto refused = parse_message(encode_message(odd));
    ASSERT_FALSE(refused) << rate_hz;
    EXPECT_EQ(refused.error().code, ErrorCode::out_of_range) << rate_hz;
    EXPECT_THAT(refused.error().message(), HasSubstr("8000 to 192000 Hz"));
  }
  SoundMessage late = kMessage;
  late.count = kMostSamples;
  EXPECT_EQ(parse_message(encode_message(late)).error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::speech::sound_message_test
