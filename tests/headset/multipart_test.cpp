#include "mien/headset/multipart.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "mien/core/random.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::multipart_test {
namespace {

using namespace test;
using sensor::StreamCounts;

struct Taken {
  Bytes jpeg;
  std::optional<DeviceTime> time;
};

std::vector<Taken> taken(MultipartReader& reader, std::span<const std::byte> bytes,
                         std::size_t piece = 1460) {
  std::vector<Taken> out;
  while (!bytes.empty()) {
    auto some = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(some.size());
    while (const auto picture = reader.read(some))
      out.push_back({{picture->jpeg.begin(), picture->jpeg.end()}, picture->time});
  }
  return out;
}

/// As the boards send it.
std::string part_head(std::string_view length, std::string_view time) {
  return fmt::format(
      "\r\n--123456789000000000000987654321\r\nContent-Type: image/jpeg\r\n"
      "Content-Length: {}\r\nX-Timestamp: {}\r\n\r\n",
      length, time);
}

DeviceTime at_us(std::int64_t us) {
  return DeviceTime(std::chrono::microseconds(us));
}

TEST(Multipart, GivesEachPictureWithItsTime) {
  Bytes stream;
  std::vector<Bytes> sent;
  for (int i = 0; i < 5; ++i) {
    sent.push_back(i % 2 == 0 ? grey_jpeg(64, 48, i) : colour_jpeg(64, 48, i));
    stream += part_head(std::to_string(sent.back().size()), fmt::format("12.{:06}", 16'667 * i));
    stream += sent.back();
  }
  for (const std::size_t piece : {1, 2, 3, 7, 1460, 1'000'000}) {
    MultipartReader reader;
    const auto got = taken(reader, stream, piece);
    ASSERT_EQ(got.size(), sent.size()) << piece;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_EQ(got[i].jpeg, sent[i]);
      EXPECT_EQ(got[i].time, at_us(12'000'000 + 16'667 * static_cast<std::int64_t>(i)));
    }
    EXPECT_EQ(reader.counts(), (StreamCounts{.whole = 5}));
  }
}

TEST(Multipart, NeedsNeitherLengthsNorBoundariesNorTimes) {
  const Bytes one = grey_jpeg(40, 40, 1);
  const Bytes two = grey_jpeg(40, 40, 2);
  for (const std::string between : {"", "\r\n", "\r\n--frame\r\nContent-Type: image/jpeg\r\n\r\n",
                                    "--frame\n\n", "any text at all, \xFF\xD8 too"}) {
    Bytes stream = text_bytes(between);
    stream += one;
    stream += between;
    stream += two;
    MultipartReader reader;
    const auto got = taken(reader, stream);
    ASSERT_EQ(got.size(), 2u) << between;
    EXPECT_EQ(got[0].jpeg, one);
    EXPECT_EQ(got[1].jpeg, two);
    EXPECT_FALSE(got[0].time || got[1].time);
  }
}

TEST(Multipart, LengthsThatLieDoNoHarm) {
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  const std::vector<std::string> lengths = {"-1",
                                            "0",
                                            "1",
                                            "4294967296",
                                            "18446744073709551616",
                                            "x",
                                            "",
                                            std::to_string(jpeg.size() - 1),
                                            std::to_string(jpeg.size() + 100)};
  for (const std::string& length : lengths) {
    Bytes stream;
    for (int i = 0; i < 3; ++i) {
      stream += part_head(length, "1.5");
      stream += jpeg;
    }
    MultipartReader reader;
    const auto got = taken(reader, stream);
    ASSERT_EQ(got.size(), 3u) << length;
    for (const Taken& one : got) {
      EXPECT_EQ(one.jpeg, jpeg);
      EXPECT_EQ(one.time, at_us(1'500'000));
    }
  }
}

TEST(Multipart, WhatStandsInAPictureEndsNothing) {
  // A thumbnail in an APP segment is a whole JPEG of its own; a comment may hold any text.
  const Bytes thumbnail = grey_jpeg(8, 8, 3);
  Bytes jpeg = with_segment(grey_jpeg(40, 40, 1), 0xE1, thumbnail);
  jpeg = with_segment(jpeg, 0xFE, text_bytes(part_head("77", "9.0")));
  Bytes stream = text_bytes(part_head("1", "2.25"));
  stream += jpeg;
  MultipartReader reader;
  const auto got = taken(reader, stream);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].jpeg, jpeg);
  EXPECT_EQ(got[0].time, at_us(2'250'000));
}

TEST(Multipart, OneThatIsCutCostsItselfAlone) {
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  const std::size_t coded = place_of(jpeg, 0xDA) + 12;
  for (std::size_t cut = coded; cut < jpeg.size(); ++cut) {
    Bytes stream = text_bytes(part_head("1000", "1.0"));
    stream += std::span(jpeg).first(cut);
    stream += part_head("1000", "2.0");
    stream += jpeg;
    MultipartReader reader;
    const auto got = taken(reader, stream);
    ASSERT_EQ(got.size(), 1u) << cut;
    EXPECT_EQ(got[0].jpeg, jpeg);
    EXPECT_EQ(got[0].time, at_us(2'000'000)) << "the next one's time is its own: " << cut;
    EXPECT_EQ(reader.counts(), (StreamCounts{.whole = 1, .broken = 1}));
  }
}

TEST(Multipart, CutAnywhereItIsRightAgainSoon) {
  // Cut behind a segment's marker, the text that follows is taken for its length: "\r\n", 3338 bytes.
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  const std::size_t lost = 1 + 3338 / jpeg.size();
  for (std::size_t cut = 0; cut < jpeg.size(); ++cut) {
    Bytes stream(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(cut));
    for (std::size_t i = 0; i < lost + 2; ++i) {
      stream += part_head("1000", "2.0");
      stream += jpeg;
    }
    MultipartReader reader;
    const auto got = taken(reader, stream);
    ASSERT_GE(got.size(), 2u) << cut;
    EXPECT_EQ(got.back().jpeg, jpeg);
    EXPECT_EQ(got.back().time, at_us(2'000'000));
  }
}

TEST(Multipart, TooLongOnesAreSkippedWholeAndCounted) {
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  Bytes stream = text_bytes(part_head("1", "1.0"));
  stream += overlong_jpeg(jpeg);
  stream += part_head("1", "2.0");
  stream += jpeg;
  MultipartReader reader;
  const auto got = taken(reader, stream);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].jpeg, jpeg);
  EXPECT_EQ(got[0].time, at_us(2'000'000));
  EXPECT_EQ(reader.counts(), (StreamCounts{.whole = 1, .overlong = 1}));
}

TEST(Multipart, ThatNeverEndsTakesNoMemory) {
  MultipartReader reader;
  Bytes jpeg = grey_jpeg(40, 40, 1);
  jpeg.resize(place_of(jpeg, 0xDA) + 12);  // Its header, and then zeros for ever.
  const Bytes zeros(1 << 20);
  EXPECT_TRUE(taken(reader, jpeg).empty());
  const std::size_t before = mien::test::allocation_count();
  for (int i = 0; i < 20; ++i) {
    std::span<const std::byte> some = zeros;
    EXPECT_FALSE(reader.read(some));
  }
  EXPECT_EQ(mien::test::allocation_count(), before);
  reader.restart();
  EXPECT_EQ(reader.counts(), (StreamCounts{.overlong = 1}));
}

TEST(Multipart, AllocatesNothingOnTheWay) {
  Bytes stream = text_bytes(part_head("1", "1.0"));
  stream += grey_jpeg(64, 64, 1);
  MultipartReader reader;
  const std::size_t before = mien::test::allocation_count();
  for (int i = 0; i < 100; ++i) {
    std::span<const std::byte> some = stream;
    EXPECT_TRUE(reader.read(some));
  }
  EXPECT_EQ(mien::test::allocation_count(), before);
}

TEST(Multipart, ARestartForgetsWhatWasOpen) {
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  MultipartReader reader;
  Bytes begun = text_bytes(part_head("1", "1.0"));
  begun += std::span(jpeg).first(jpeg.size() / 2);
  EXPECT_TRUE(taken(reader, begun).empty());
  reader.restart();
  const auto got = taken(reader, jpeg);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].jpeg, jpeg);
  EXPECT_FALSE(got[0].time);
  EXPECT_EQ(reader.counts(), (StreamCounts{.whole = 1, .broken = 1}));
}

TEST(Multipart, SurvivesDamage) {
  Random random(5);
  Bytes stream;
  for (int i = 0; i < 20; ++i) {
    stream += part_head("1", "1.0");
    stream += grey_jpeg(40, 40, i % 5);
  }
  for (int i = 0; i < 50; ++i) {
    Bytes damaged = stream;
    for (int j = 0; j < 20; ++j)
      damaged[random.below(damaged.size())] = static_cast<std::byte>(random.below(256));
    MultipartReader reader;
    const auto got = taken(reader, damaged);
    EXPECT_LE(got.size(), 25u);
    EXPECT_GE(got.size(), 1u);
  }
}

TEST(Timestamp, IsReadAsTheBoardsWriteIt) {
  EXPECT_EQ(parse_timestamp("12.345678"), at_us(12'345'678));
  EXPECT_EQ(parse_timestamp("0.000001"), at_us(1));
  EXPECT_EQ(parse_timestamp("7"), at_us(7'000'000));
  EXPECT_EQ(parse_timestamp("7.5"), at_us(7'500'000));
  EXPECT_EQ(parse_timestamp("1764180000.000002"), at_us(64'180'000'000'002)) << "counted from 1970";
  for (const char* text : {"", "-1", "-1.0", "+1.0", "1.", ".5", "1.0000001", "1,5", "1.5x", "x", "nan",
                           "1e3", "99999999999999999999", "0x10", " 1"})
    EXPECT_FALSE(parse_timestamp(text)) << text;
}

TEST(Timestamp, OfAPartThatHasNoneIsNotThatOfTheOneBefore) {
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  Bytes stream = text_bytes("--a\r\nX-TIMESTAMP:   3.5  \r\n\r\n");
  stream += jpeg;
  stream += "--a\r\n\r\n";
  stream += jpeg;
  stream += "--a\r\nx-timestamp: 4.0\r\n--a\r\n\r\n";  // A part without its picture.
  stream += jpeg;
  stream += "--a\r\nX-Timestamp: 4.0 " + std::string(100, ' ') + "\r\n";  // Too long a line.
  stream += jpeg;
  MultipartReader reader;
  const auto got = taken(reader, stream);
  ASSERT_EQ(got.size(), 4u);
  EXPECT_EQ(got[0].time, at_us(3'500'000));
  EXPECT_FALSE(got[1].time);
  EXPECT_FALSE(got[2].time);
  EXPECT_FALSE(got[3].time);
}

}  // namespace
}  // namespace mien::headset::multipart_test
