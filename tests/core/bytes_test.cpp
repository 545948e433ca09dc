#include "mien/core/bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace mien::bytes_test {
namespace {

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int v : values) bytes.push_back(static_cast<std::byte>(v));
  return bytes;
}

std::uint32_t crc_of(std::string_view text) {
  return crc32(std::as_bytes(std::span(text)));
}

TEST(ByteReader, ReadsBothByteOrders) {
  const auto bytes = bytes_of({0x01, 0x02, 0x03, 0x04, 0x01, 0x02, 0x03, 0x04, 0xFF, 0xFE});
  ByteReader reader(bytes);
  EXPECT_EQ(reader.little<std::uint32_t>(), 0x04030201U);
  EXPECT_EQ(reader.big<std::uint32_t>(), 0x01020304U);
  EXPECT_EQ(reader.big<std::int16_t>(), -2);
  EXPECT_EQ(reader.left(), 0U);
  EXPECT_TRUE(reader.ok());
}

TEST(ByteReader, ReadsFloatsBitForBit) {
  ByteWriter writer;
  writer.little(1.5F);
  writer.big(-0.0);
  writer.little(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(std::to_integer<int>(writer.bytes()[3]), 0x3F);  // 1.5F is 0x3FC00000.
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.little<float>(), 1.5F);
  EXPECT_TRUE(std::signbit(reader.big<double>()));
  EXPECT_TRUE(std::isnan(reader.little<double>()));
  EXPECT_TRUE(reader.ok());
}

TEST(ByteReader, GivesZeroPastTheEndAndSaysSoForGood) {
  const auto bytes = bytes_of({1, 2, 3});
  ByteReader reader(bytes);
  EXPECT_EQ(reader.little<std::uint32_t>(), 0U);
  EXPECT_FALSE(reader.ok());
  // What would still have fitted is not given out after a failure: a half-read record must not look whole.
  EXPECT_EQ(reader.little<std::uint8_t>(), 0U);
  EXPECT_EQ(reader.left(), 0U);
  EXPECT_FALSE(reader.ok());
}

TEST(ByteReader, TakesNothingFromNothing) {
  ByteReader reader({});
  EXPECT_TRUE(reader.take(0).empty());
  EXPECT_TRUE(reader.ok());
  EXPECT_TRUE(reader.take(std::numeric_limits<std::size_t>::max()).empty());
  EXPECT_FALSE(reader.ok());
}

TEST(ByteReader, TakesPieces) {
  const auto bytes = bytes_of({1, 2, 3, 4});
  ByteReader reader(bytes);
  EXPECT_EQ(reader.take(3).size(), 3U);
  EXPECT_EQ(reader.left(), 1U);
  EXPECT_EQ(reader.little<std::uint8_t>(), 4U);
  EXPECT_TRUE(reader.ok());
}

TEST(ByteWriter, GivesBackWhatReaderReads) {
  ByteWriter writer;
  writer.little(std::uint64_t{0x0123456789ABCDEF});
  writer.big(std::int32_t{-7});
  writer.append(std::string_view("mien"));
  const auto bytes = writer.release();
  ASSERT_EQ(bytes.size(), 16U);
  ByteReader reader(bytes);
  EXPECT_EQ(reader.little<std::uint64_t>(), 0x0123456789ABCDEFU);
  EXPECT_EQ(reader.big<std::int32_t>(), -7);
  const auto text = reader.take(4);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(text.data()), text.size()), "mien");
}

TEST(Crc32, KnownVectors) {
  EXPECT_EQ(crc_of("123456789"), 0xCBF43926U);
  EXPECT_EQ(crc_of(""), 0U);
  EXPECT_EQ(crc_of("a"), 0xE8B7BE43U);
  EXPECT_EQ(crc_of("The quick brown fox jumps over the lazy dog"), 0x414FA339U);
}

TEST(Crc32, SeesEverySingleBit) {
  auto bytes = bytes_of({0x4D, 0x49, 0x45, 0x4E, 0, 1, 2, 3, 250, 251});
  const std::uint32_t right = crc32(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    EXPECT_NE(crc32(bytes), right) << "bit " << bit;
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  }
}

}  // namespace
}  // namespace mien::bytes_test
