#include "mien/live/byte_ring.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
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

/// Resident memory of this process, bytes.
std::size_t resident() {
  std::size_t all = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> all >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST(ByteRing, TouchesNoMoreMemoryThanEverWaited) {
  constexpr std::size_t kSize = std::size_t{64} << 20, kRecord = 100'000;
  ByteRing ring(kSize, ByteRing::Memory::when_used);
  const std::size_t before = resident();
  std::size_t most = 0;
  for (std::size_t i = 0; i < 2 * kSize / kRecord; ++i) {
    const std::span<std::byte> room = ring.claim(kRecord);
    ASSERT_EQ(room.size(), kRecord);
    std::memset(room.data(), static_cast<int>(i & 0xFF), kRecord);
    ring.publish();
    const std::span<const std::byte> record = ring.front();
    ASSERT_EQ(record.size(), kRecord);
    ASSERT_EQ(record.front(), static_cast<std::byte>(i & 0xFF));
    ASSERT_EQ(record.back(), record.front());
    ring.release();
    most = std::max(most, resident());
  }
  EXPECT_LT(most, before + kSize / 4) << "hardly more than what waits";
}

TEST(ByteRing, KeepsWhatWaitsWhereverItBegan) {
  ByteRing ring(1 << 12);
  Random sizes(1), others(1), turns(2);
  std::size_t waiting = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::size_t size = 4 + sizes.below(600);
    // Now and then all is read, elsewhere the ring goes round.
    while (waiting > (turns.chance(0.1) ? 0U : 3U)) {
      const std::span<const std::byte> record = ring.front();
      ASSERT_EQ(record.size(), 4 + others.below(600));
      ASSERT_EQ(record.front(), static_cast<std::byte>(record.size() & 0xFF));
      ASSERT_EQ(record.back(), record.front());
      ring.release();
      --waiting;
    }
    const std::span<std::byte> room = ring.claim(size);
    ASSERT_EQ(room.size(), size);
    std::memset(room.data(), static_cast<int>(size & 0xFF), size);
    ring.publish();
    ++waiting;
  }
}

}  // namespace
}  // namespace mien::live::byte_ring_test
