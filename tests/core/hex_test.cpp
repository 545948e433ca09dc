#include "mien/core/encoding.h"

#include <gtest/gtest.h>

#include <array>

namespace mien::hex_test {
namespace {

TEST(Hex, WritesTwoLowerCaseDigitsAByte) {
  EXPECT_EQ(hex({}), "");
  EXPECT_EQ(hex(std::array{std::byte{0}, std::byte{0x0a}, std::byte{0xff}}), "000aff");
}

}  // namespace
}  // namespace mien::hex_test
