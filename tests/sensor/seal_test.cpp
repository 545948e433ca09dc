#include "mien/sensor/seal.h"

#include <gtest/gtest.h>

#include <initializer_list>

#include "tests/hex.h"

namespace mien::sensor::seal_test {
namespace {

SealKey key() {
  SealKey k{.id = 3};
  for (std::size_t i = 0; i < k.secret.size(); ++i) k.secret[i] = static_cast<std::byte>(i);
  return k;
}

constexpr SealHeader kHeader{
    .key_id = 3, .device = 0x024D49454E07, .counter = (2ULL << 32U) + 258, .session = 0x1122334455667788};

/// The document's pulse.
std::vector<std::byte> pulse() {
  return bytes_of("4d49454e01060000074e45494d02000087d612000000000002010000666d0fde");
}

// The test vector of docs/reference/protocol.md.
TEST(Seal, MatchesTheDocumentsBytes) {
  ByteWriter writer;
  ASSERT_TRUE(seal_packet(key(), kHeader, pulse(), writer));
  EXPECT_EQ(hex(writer.bytes()),
            "4d49454e01070300074e45494d02000002010000020000008877665544332211"
            "0da6063c6e770dc9f8aed51032f8fc6b0d0fd57c435e29225cd8ece64ff92be7"
            "ee538f60f3a98ae7c1b6c7b9a996407c7eca530b");
}

TEST(Seal, OpensToWhatWasSealed) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{100}, kMaxSealedInner}) {
    const std::vector<std::byte> inner(size, std::byte{0x5A});
    ByteWriter writer;
    ASSERT_TRUE(seal_packet(key(), kHeader, inner, writer));
    EXPECT_TRUE(is_sealed(writer.bytes()));
    EXPECT_EQ(writer.bytes().size(), size + 52);
    std::vector<std::byte> opened;
    const auto header = open_sealed(std::vector{key()}, writer.bytes(), opened);
    ASSERT_TRUE(header) << header.error().message();
    EXPECT_EQ(*header, kHeader);
    EXPECT_EQ(opened, inner);
  }
}

TEST(Seal, HidesWhatIsInside) {
  ByteWriter writer;
  ASSERT_TRUE(seal_packet(key(), kHeader, pulse(), writer));
  EXPECT_EQ(hex(writer.bytes()).find(hex(pulse()).substr(32, 16)), std::string::npos);
}

TEST(Seal, SealsNothingThatItWouldNotOpen) {
  ByteWriter writer;
  EXPECT_FALSE(seal_packet(key(), kHeader, {}, writer));
  EXPECT_FALSE(seal_packet(key(), kHeader, std::vector<std::byte>(kMaxSealedInner + 1), writer));
  SealHeader other = kHeader;
  other.key_id = 4;
  EXPECT_FALSE(seal_packet(key(), other, pulse(), writer));
  EXPECT_TRUE(writer.bytes().empty());
  ASSERT_TRUE(seal_packet(key(), kHeader, pulse(), writer));
  const std::vector<std::byte> sealed(writer.bytes().begin(), writer.bytes().end());
  EXPECT_FALSE(seal_packet(key(), kHeader, sealed, writer));
}

TEST(Seal, RefusesForeignHeaders) {
  ByteWriter writer;
  ASSERT_TRUE(seal_packet(key(), kHeader, pulse(), writer));
  const auto whole = writer.release();
  const auto changed = [&](std::size_t at, int value) {
    auto bytes = whole;
    bytes[at] = static_cast<std::byte>(value);
    renew_checksum(bytes);
    std::vector<std::byte> inner(3);
    const auto header = open_sealed(std::vector{key()}, bytes, inner);
    EXPECT_FALSE(header);
    EXPECT_TRUE(inner.empty());
    return header ? ErrorCode::internal : header.error().code;
  };
  EXPECT_EQ(changed(3, 'n'), ErrorCode::malformed);
  EXPECT_EQ(changed(4, 2), ErrorCode::unsupported);
  EXPECT_EQ(changed(5, 6), ErrorCode::unsupported);
  EXPECT_EQ(changed(6, 4), ErrorCode::mismatch);
  EXPECT_EQ(changed(7, 1), ErrorCode::malformed);
}

TEST(ReplayWindow, LetsEachCounterInOnce) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(1000));
  for (std::uint64_t back = 1; back < ReplayWindow::kWidth; back += 2)
    EXPECT_TRUE(window.accept(1000 - back));
  for (std::uint64_t back = 1; back < ReplayWindow::kWidth; ++back)
    EXPECT_EQ(window.accept(1000 - back), back % 2 == 0) << back;
  EXPECT_FALSE(window.accept(1000));
  EXPECT_FALSE(window.accept(1000 - ReplayWindow::kWidth));
  EXPECT_TRUE(window.accept(1000 + ReplayWindow::kWidth));
  EXPECT_FALSE(window.accept(1000));
  EXPECT_TRUE(window.accept(1001));
  EXPECT_TRUE(window.accept(~std::uint64_t{0}));
  EXPECT_FALSE(window.accept(1064));
}

TEST(ReplayWindow, BeginsAnywhere) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(0));
  EXPECT_FALSE(window.accept(0));
  EXPECT_TRUE(window.accept(1));
}

}  // namespace
}  // namespace mien::sensor::seal_test
