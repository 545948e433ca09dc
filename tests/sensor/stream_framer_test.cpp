#include "mien/sensor/stream_framer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/cobs.h"
#include "mien/core/random.h"

namespace mien::sensor::stream_framer_test {
namespace {

using namespace std::string_literals;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> frames(StreamFramer& framer, std::string_view stream) {
  std::vector<std::string> all;
  for (const char c : stream) {
    const auto frame = framer.add(static_cast<std::byte>(c));
    if (!frame.empty()) all.emplace_back(reinterpret_cast<const char*>(frame.data()), frame.size());
  }
  return all;
}

std::vector<std::string> frames(std::string_view stream) {
  StreamFramer framer;
  return frames(framer, stream);
}

TEST(StreamFramer, LinesEndAtNewlines) {
  EXPECT_THAT(frames("1,2\n3\t4\r\n\r\n\n5"), ElementsAre("1,2", "3\t4"));
}

TEST(StreamFramer, BinaryFramesEndAtZeros) {
  EXPECT_THAT(frames("\x03\x01\n\x02\0\0\x05"s + "abc\0"s), ElementsAre("\x03\x01\n\x02", "\x05"s + "abc"));
}

TEST(StreamFramer, TextMayEndAtZerosToo) {
  EXPECT_THAT(frames("1,2\0\n"s), ElementsAre("1,2"));
}

TEST(StreamFramer, ANewlineMayBeAFramesFirstCode) {
  EXPECT_THAT(frames("\nMIEN\x01 123\x02z\0\nMIEN\x01 123\x02z\0"s),
              ElementsAre("\nMIEN\x01 123\x02z", "\nMIEN\x01 123\x02z"));
  EXPECT_THAT(frames("\n1,2\n3,4\n"), ElementsAre("1,2", "3,4"));
  EXPECT_THAT(frames("\n\n\r\n1\r\n"), ElementsAre("1"));
}

TEST(StreamFramer, ABootMessageBeforeBinaryFramesCostsOneAtTheMost) {
  const std::string frame = "\x05\x01\n\xff\x02"s;
  // The first is taken for a damaged line and cut at its newline; then a zero ends frames again.
  EXPECT_THAT(frames("rst:0x1\r\n" + frame + '\0' + frame + '\0' + frame + '\0'),
              ElementsAre("rst:0x1", "\x05\x01", "\xff\x02", frame, frame));
}

TEST(StreamFramer, ADamagedLineCostsItselfAlone) {
  EXPECT_THAT(frames("1,2\n1,\xff\n3,4\n5,6\n"), ElementsAre("1,2", "1,\xff", "3,4", "5,6"));
}

TEST(StreamFramer, LongFramesAreDroppedAndCounted) {
  StreamFramer framer;
  const std::string most(StreamFramer::kMaxFrame, '7');
  EXPECT_THAT(frames(framer, most + "\n"), ElementsAre(most));
  EXPECT_EQ(framer.overlong(), 0u);
  EXPECT_THAT(frames(framer, most + "7\n1\n"), ElementsAre("1"));
  EXPECT_EQ(framer.overlong(), 1u);
  EXPECT_THAT(frames(framer, std::string(100'000, '\xfe')), IsEmpty());
  EXPECT_THAT(frames(framer, "\0"s + "1\n"), ElementsAre("1"));
  EXPECT_EQ(framer.overlong(), 2u);
}

TEST(StreamFramer, TextComesBackAfterNoiseThatHeldAZero) {
  std::string stream = "1,2\n\xfe\0\xfe"s;
  for (int i = 0; i < 200; ++i) stream += "3,4\n";
  const auto received = frames(stream);
  EXPECT_GT(received.size(), 2 + 200 - StreamFramer::kMaxFrame / 4 - 2);
  EXPECT_EQ(received.back(), "3,4");
}

TEST(StreamFramer, BeginsAnew) {
  StreamFramer framer;
  EXPECT_THAT(frames(framer, "1\n12"), ElementsAre("1"));
  framer.restart();
  EXPECT_THAT(frames(framer, "3,4\n"), ElementsAre("3,4"));
}

// Whatever comes, nothing is longer than it may be, and behind a zero everything is as it was.
TEST(StreamFramer, FindsBackFromNoise) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    StreamFramer framer;
    for (std::uint64_t k = random.below(2000); k > 0; --k)
      EXPECT_LE(framer.add(static_cast<std::byte>(random.below(256))).size(), StreamFramer::kMaxFrame);
    std::vector<std::byte> data(2 + random.below(300));
    for (auto& b : data) b = static_cast<std::byte>(random.below(256));
    data[0] = std::byte{1};  // What is no text within its first bytes is never cut at a newline.
    std::vector<std::byte> frame;
    cobs_encode(data, frame);
    static_cast<void>(framer.add(std::byte{0}));
    for (const std::byte b : frame) ASSERT_TRUE(framer.add(b).empty());
    ASSERT_TRUE(std::ranges::equal(framer.add(std::byte{0}), frame));
  }
}

}  // namespace
}  // namespace mien::sensor::stream_framer_test
