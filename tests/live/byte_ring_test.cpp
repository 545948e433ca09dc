#include "mien/live/byte_ring.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <thread>
#include <vector>

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

/// Resident memory of this process, bytes.
std::size_t resident() {
  std::size_t all = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> all >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST(ByteRing, EmptiedNowAndThenItTouchesOnlyWhatCameInBetween) {
  constexpr std::size_t kSize = std::size_t{64} << 20, kRecord = 100'000;
  ByteRing ring(kSize);
  const std::size_t before = resident();
  for (std::size_t i = 0; i < 2 * kSize / kRecord; ++i) {
    const std::span<std::byte> room = ring.claim(kRecord);
    ASSERT_EQ(room.size(), kRecord);
    std::memset(room.data(), static_cast<int>(i & 0xFF), kRecord);
    ring.publish();
    ASSERT_EQ(ring.front().size(), kRecord);
    ring.release();
  }
  EXPECT_LT(resident(), before + kSize / 4);
}

void write(ByteRing& ring, int number, std::size_t size) {
  const std::span<std::byte> room = ring.claim(size);
  ASSERT_EQ(room.size(), size);
  std::memset(room.data(), number & 0xFF, size);
  std::memcpy(room.data(), &number, sizeof(number));
  ring.publish();
}

void expect_next(ByteRing& ring, int number, std::size_t size) {
  const std::span<const std::byte> record = ring.front();
  ASSERT_EQ(record.size(), size);
  int is = -1;
  std::memcpy(&is, record.data(), sizeof(is));
  EXPECT_EQ(is, number);
  EXPECT_EQ(record.back(), static_cast<std::byte>(number & 0xFF));
  ring.release();
}

TEST(ByteRing, KeepsWhatWaitsWhereverItBegan) {
  ByteRing ring(1 << 12);
  Random sizes(1), turns(2);
  std::vector<std::size_t> size_of;
  int next = 0, emptied = 0;
  for (int i = 0; i < 20'000; ++i) {
    // Now and then all is read; between that the ring goes round.
    const int waits = turns.chance(0.1) ? 0 : 3;
    emptied += waits == 0 ? 1 : 0;
    for (; i - next > waits; ++next) expect_next(ring, next, size_of[static_cast<std::size_t>(next)]);
    size_of.push_back(8 + sizes.below(600));
    write(ring, i, size_of.back());
  }
  EXPECT_GT(emptied, 1000);
}

TEST(ByteRing, AClaimThatIsNotPublishedLeavesNothing) {
  ByteRing ring(256);
  // Three of 56 bytes and one of 48; the last is still there, and the next would go round.
  for (int i = 0; i < 4; ++i) write(ring, i, i < 3 ? 50 : 40);
  for (int i = 0; i < 3; ++i) expect_next(ring, i, 50);
  EXPECT_EQ(ring.claim(60).size(), 60U) << "beyond the end: what is left of the ring is skipped";
  expect_next(ring, 3, 40);
  EXPECT_TRUE(ring.front().empty());
  // Claimed anew from the front, twice, and handed over once.
  EXPECT_EQ(ring.claim(20).size(), 20U);
  write(ring, 4, 30);
  expect_next(ring, 4, 30);
  EXPECT_TRUE(ring.front().empty());
}

}  // namespace
}  // namespace mien::live::byte_ring_test
