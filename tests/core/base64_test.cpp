#include "mien/core/encoding.h"

#include <gtest/gtest.h>

#include <array>
#include <string_view>

namespace mien::base64_test {
namespace {

TEST(Base64, KeepsToTheStandard) {
  // RFC 4648, section 10.
  const auto of = [](std::string_view text) { return base64(std::as_bytes(std::span(text))); };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foo"), "Zm9v");
  EXPECT_EQ(of("foob"), "Zm9vYg==");
  EXPECT_EQ(of("fooba"), "Zm9vYmE=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

TEST(Base64, KnowsEveryDigit) {
  // Six bits each, ascending: the alphabet itself.
  std::array<std::byte, 48> bytes{};
  for (unsigned digit = 0; digit < 64; ++digit)
    for (unsigned bit = 0; bit < 6; ++bit)
      if ((digit >> (5 - bit) & 1U) != 0)
        bytes[(6 * digit + bit) / 8] |= std::byte{0x80} >> ((6 * digit + bit) % 8);
  EXPECT_EQ(base64(bytes), "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/");
}

}  // namespace
}  // namespace mien::base64_test
