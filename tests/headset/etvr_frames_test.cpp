#include "mien/headset/etvr_frames.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::etvr_frames_test {
namespace {

using namespace test;
using sensor::StreamCounts;

Bytes frame(const Bytes& jpeg, std::size_t length) {
  Bytes out = {std::byte{0xFF},
               std::byte{0xA0},
               std::byte{0xFF},
               std::byte{0xA1},
               static_cast<std::byte>(length),
               static_cast<std::byte>(length >> 8U)};
  out += jpeg;
  return out;
}
Bytes frame(const Bytes& jpeg) {
  return frame(jpeg, jpeg.size());
}

std::vector<Bytes> taken(EtvrFrames& frames, std::span<const std::byte> bytes, std::size_t piece = 64) {
  std::vector<Bytes> out;
  while (!bytes.empty()) {
    auto some = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(some.size());
    while (const auto picture = frames.read(some)) out.emplace_back(picture->begin(), picture->end());
  }
  return out;
}

class Etvr : public ::testing::Test {
 protected:
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  EtvrFrames frames;
};

TEST_F(Etvr, GivesEachPicture) {
  Bytes stream;
  std::vector<Bytes> sent;
  for (int i = 0; i < 4; ++i) {
    sent.push_back(colour_jpeg(40, 40, i));
    stream += frame(sent.back());
  }
  for (const std::size_t piece : {1, 3, 64, 100'000}) {
    EtvrFrames fresh;
    EXPECT_EQ(taken(fresh, stream, piece), sent);
    EXPECT_EQ(fresh.counts(), StreamCounts{.whole = 4});
  }
}

TEST_F(Etvr, IsRightAgainBehindGarbage) {
  Bytes stream = text_bytes("boot: \xFF\xA0 rst 0x1 \xFF\xA0\xFF\xA1 and \xFF\xD8\xFF\xE0\n");
  stream += frame(jpeg);
  stream += text_bytes("\xFF\xA0\xFF\xA0\xFF\xA1");
  stream += frame(jpeg);
  EXPECT_EQ(taken(frames, stream), (std::vector<Bytes>{jpeg, jpeg}));
  EXPECT_EQ(frames.counts(), StreamCounts{.whole = 2});
}

TEST_F(Etvr, APictureBehindALengthThatLiesIsBrokenAndTheNextIsNot) {
  for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{2}, jpeg.size() - 1,
                                   jpeg.size() + 1, std::size_t{0xFFFF}}) {
    EtvrFrames fresh;
    Bytes stream = frame(jpeg, length);
    stream += frame(jpeg);
    EXPECT_EQ(taken(fresh, stream), std::vector<Bytes>{jpeg}) << length;
    EXPECT_EQ(fresh.counts(), (StreamCounts{.whole = 1, .broken = 1})) << length;
  }
}

TEST_F(Etvr, OneThatLostBytesIsBroken) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    Bytes damaged = jpeg;
    const std::size_t from = 2 + random.below(jpeg.size() - 20);
    const auto first = damaged.begin() + static_cast<std::ptrdiff_t>(from);
    damaged.erase(first, first + 1 + static_cast<std::ptrdiff_t>(random.below(16)));
    EtvrFrames fresh;
    Bytes stream = frame(damaged, jpeg.size());
    stream += frame(jpeg);
    EXPECT_EQ(taken(fresh, stream), std::vector<Bytes>{jpeg});
    EXPECT_EQ(fresh.counts(), (StreamCounts{.whole = 1, .broken = 1}));
  }
}

TEST_F(Etvr, ARestartForgetsWhatWasOpen) {
  const Bytes all = frame(jpeg);
  static_cast<void>(taken(frames, std::span(all).first(all.size() / 2)));
  frames.restart();
  EXPECT_TRUE(taken(frames, std::span(all).last(all.size() / 2)).empty());
  EXPECT_EQ(taken(frames, all).size(), 1u);
  EXPECT_EQ(frames.counts(), (StreamCounts{.whole = 1, .broken = 1}));
}

TEST_F(Etvr, AllocatesNothingOnTheWay) {
  const Bytes all = frame(jpeg);
  const std::size_t before = mien::test::allocation_count();
  for (int i = 0; i < 20; ++i) {
    std::span<const std::byte> bytes = all;
    EXPECT_TRUE(frames.read(bytes));
  }
  EXPECT_EQ(mien::test::allocation_count(), before);
}

}  // namespace
}  // namespace mien::headset::etvr_frames_test
