#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "tests/hex.h"

// What every parser of packets with a checksum at their end refuses. `parse`: from bytes to a Result.
namespace mien {

template <class Parse>
void expect_refuses_truncation_and_trailing_bytes(std::vector<std::byte> bytes, Parse parse) {
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(parse(std::span(bytes).first(size))) << size;
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(parse(bytes));
}

template <class Parse>
void expect_refuses_flipped_bits(const std::vector<std::byte>& good, Parse parse) {
  for (std::size_t i = 0; i < 8 * good.size(); ++i) {
    auto bytes = good;
    bytes[i / 8] ^= std::byte{static_cast<unsigned char>(1U << (i % 8))};
    EXPECT_FALSE(parse(bytes)) << "bit " << i;
  }
}

/// A good packet with some of its bytes overwritten, and the error that it must give.
struct WrongField {
  const char* name;
  std::size_t at;
  std::vector<unsigned> bytes;
  ErrorCode code;
};

/// Each alone, with a right checksum.
template <class Parse>
void expect_refuses_wrong_fields(const std::vector<std::byte>& good, const std::vector<WrongField>& cases,
                                 Parse parse) {
  for (const WrongField& wrong : cases) {
    auto bytes = good;
    for (std::size_t i = 0; i < wrong.bytes.size(); ++i)
      bytes[wrong.at + i] = std::byte{static_cast<unsigned char>(wrong.bytes[i])};
    renew_checksum(bytes);
    const auto packet = parse(bytes);
    ASSERT_FALSE(packet) << wrong.name;
    EXPECT_EQ(packet.error().code, wrong.code) << wrong.name << ": " << packet.error().message();
  }
}

}  // namespace mien
