#include "mien/core/sha256.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace mien::sha256_test {
namespace {

std::string sha256_of(std::string_view text) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(text)));
  return hash.hex();
}

// FIPS 180-4's own examples.
TEST(Sha256, KnownVectors) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PiecesMakeTheWhole) {
  const std::string text(1000, 'x');
  Sha256 hash;
  for (std::size_t at = 0, step = 1; at < text.size(); at += step, step = step % 97 + 13)
    hash.add(std::as_bytes(std::span(text).subspan(at, std::min(step, text.size() - at))));
  EXPECT_EQ(hash.hex(), sha256_of(text));
}

TEST(Sha256, ValuesAreTheirBytes) {
  Sha256 by_value;
  by_value.add_value(std::uint32_t{0x64636261});  // "abcd" on a little-endian machine.
  by_value.add_value(1.0F);
  Sha256 by_bytes;
  const std::array<unsigned char, 8> raw = {'a', 'b', 'c', 'd', 0, 0, 0x80, 0x3F};
  by_bytes.add(std::as_bytes(std::span(raw)));
  EXPECT_EQ(by_value.hex(), by_bytes.hex());
}

}  // namespace
}  // namespace mien::sha256_test
