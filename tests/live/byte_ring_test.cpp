#include "mien/live/byte_ring.h"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "mien/core/random.h"

namespace mien::live::byte_ring_test {
namespace {

TEST(ByteRing, RefusesWhatDoesNotFitAndGivesTheRestBackWhole) {
  ByteRing ring(256);
  EXPECT_TRUE(ring.claim(100).empty()) << "more than a quarter";
  EXPECT_TRUE(ring.front().empty());
  int written = 0;
  while (true) {
    const auto room = ring.claim(20);
    if (room.empty()) break;
    std::memset(room.data(), written++, room.size());
    ring.publish();
  }
  EXPECT_EQ(written, 10);  // 24 bytes each.
  for (int i = 0; i < written; ++i) {
    const auto record = ring.front();
    ASSERT_EQ(record.size(), 20u);
    EXPECT_EQ(record[19], static_cast<std::byte>(i));
    ring.release();
  }
  EXPECT_TRUE(ring.front().empty());
}

TEST(ByteRing, CarriesRecordsOfAnyLengthBetweenTwoThreads) {
  ByteRing ring(1 << 12);
  constexpr int kRecords = 20000;
  std::thread writer([&] {
    Random random(1);
    for (int i = 0; i < kRecords;) {
      const std::size_t size = 4 + random.below(500);
      std::span<std::byte> room = ring.claim(size);
      while (room.empty()) {
        std::this_thread::yield();
        room = ring.claim(size);
      }
      std::memset(room.data(), i & 0xFF, size);
      std::memcpy(room.data(), &i, sizeof(i));
      ring.publish();
      ++i;
    }
  });
  Random random(1);
  for (int i = 0; i < kRecords; ++i) {
    const std::size_t size = 4 + random.below(500);
    std::span<const std::byte> record = ring.front();
    while (record.empty()) {
      std::this_thread::yield();
      record = ring.front();
    }
    int number = -1;
    std::memcpy(&number, record.data(), sizeof(number));
    ASSERT_EQ(number, i);
    ASSERT_EQ(record.size(), size);
    if (size > 4) {
      ASSERT_EQ(record.back(), static_cast<std::byte>(i & 0xFF));
    }
    ring.release();
  }
  writer.join();
}

}  // namespace
}  // namespace mien::live::byte_ring_test
