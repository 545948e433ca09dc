#include "mien/core/cobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <numeric>

#include "mien/core/random.h"

namespace mien::cobs_test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes(std::initializer_list<int> values) {
  Bytes made;
  for (const int value : values) made.push_back(static_cast<std::byte>(value));
  return made;
}

/// first, first + 1, ..., last.
Bytes run(int first, int last) {
  Bytes made;
  for (int value = first; value <= last; ++value) made.push_back(static_cast<std::byte>(value));
  return made;
}

Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

Bytes encoded(const Bytes& data) {
  Bytes out;
  cobs_encode(data, out);
  return out;
}

Result<Bytes> decoded(const Bytes& frame, std::size_t room = 2048) {
  Bytes out(room, std::byte{0xAA});
  const auto data = cobs_decode(frame, out);
  if (!data) return std::unexpected(data.error());
  return Bytes(data->begin(), data->end());
}

struct Vector {
  Bytes data;
  Bytes frame;
};

/// The examples that descriptions of the method agree on.
std::vector<Vector> published() {
  return {
      {{}, bytes({1})},
      {bytes({0}), bytes({1, 1})},
      {bytes({0, 0}), bytes({1, 1, 1})},
      {bytes({0, 0x11, 0}), bytes({1, 2, 0x11, 1})},
      {bytes({0x11, 0x22, 0, 0x33}), bytes({3, 0x11, 0x22, 2, 0x33})},
      {bytes({0x11, 0x22, 0x33, 0x44}), bytes({5, 0x11, 0x22, 0x33, 0x44})},
      {bytes({0x11, 0, 0, 0}), bytes({2, 0x11, 1, 1, 1})},
      {run(1, 254), bytes({0xFF}) + run(1, 254)},
      {bytes({0}) + run(1, 254), bytes({1, 0xFF}) + run(1, 254)},
      {run(1, 255), bytes({0xFF}) + run(1, 254) + bytes({2, 0xFF})},
      {run(2, 255) + bytes({0}), bytes({0xFF}) + run(2, 255) + bytes({1, 1})},
      {run(3, 255) + bytes({0, 1}), bytes({0xFE}) + run(3, 255) + bytes({2, 1})},
  };
}

TEST(Cobs, MatchesThePublishedVectors) {
  for (const Vector& vector : published()) {
    EXPECT_EQ(encoded(vector.data), vector.frame);
    const auto back = decoded(vector.frame);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, vector.data);
  }
}

TEST(Cobs, TakesTheLastCodeThatSomeEncodersAddAfterAFullRun) {
  const auto back = decoded(bytes({0xFF}) + run(1, 254) + bytes({1}));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, run(1, 254));
}

TEST(Cobs, AppendsToWhatIsThere) {
  Bytes out = bytes({7});
  cobs_encode(bytes({5}), out);
  EXPECT_EQ(out, bytes({7, 2, 5}));
}

TEST(Cobs, ComesBackWhateverItIs) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    Bytes data(random.below(800));
    const std::uint64_t zeros = 1 + random.below(400);
    for (auto& b : data)
      b = random.below(zeros) == 0 ? std::byte{0} : static_cast<std::byte>(1 + random.below(255));
    const Bytes frame = encoded(data);
    EXPECT_EQ(std::ranges::count(frame, std::byte{0}), 0);
    EXPECT_LE(frame.size(), cobs_max_size(data.size()));
    const auto back = decoded(frame, frame.size());
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, data);
  }
}

TEST(Cobs, RefusesWhatIsNone) {
  EXPECT_EQ(decoded({}).error().code, ErrorCode::truncated);
  EXPECT_EQ(decoded(bytes({0})).error().code, ErrorCode::malformed);
  EXPECT_EQ(decoded(bytes({3, 5, 0})).error().code, ErrorCode::malformed);
  EXPECT_EQ(decoded(bytes({2, 5, 0, 1})).error().code, ErrorCode::malformed);
  EXPECT_EQ(decoded(bytes({2})).error().code, ErrorCode::truncated);
  EXPECT_EQ(decoded(bytes({2, 5, 9, 1})).error().code, ErrorCode::truncated);
  EXPECT_EQ(decoded(bytes({0xFF}) + run(1, 253)).error().code, ErrorCode::truncated);
}

TEST(Cobs, WritesNothingPastItsRoom) {
  for (const Vector& vector : published()) {
    for (std::size_t room = 0; room < vector.data.size(); ++room) {
      const auto back = decoded(vector.frame, room);
      ASSERT_FALSE(back);
      EXPECT_EQ(back.error().code, ErrorCode::out_of_range);
    }
    EXPECT_TRUE(decoded(vector.frame, vector.data.size()));
  }
}

}  // namespace
}  // namespace mien::cobs_test
