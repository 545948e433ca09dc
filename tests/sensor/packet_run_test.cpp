#include "mien/sensor/packet_run.h"

#include <gtest/gtest.h>

namespace mien::sensor::packet_run_test {
namespace {

DeviceTime at(std::int64_t ms) {
  return DeviceTime(std::chrono::milliseconds(ms));
}

TEST(PacketRun, IsWholeUntilTheFirstThatIsMissing) {
  PacketRun run;
  EXPECT_TRUE(run.empty());
  for (const std::uint32_t sequence : {7U, 8U, 10U, 11U}) EXPECT_TRUE(run.add(sequence, at(16 * sequence)));
  EXPECT_EQ(run.whole_until(), at(16 * 8));
  EXPECT_TRUE(run.add(9, at(16 * 9)));
  EXPECT_EQ(run.whole_until(), at(16 * 11));
}

TEST(PacketRun, CountsTheSamplesOfAPacket) {
  PacketRun run;
  EXPECT_TRUE(run.add(1, at(4)));
  EXPECT_TRUE(run.add(1, at(8)));
  EXPECT_EQ(run.whole_until(), at(8));
  EXPECT_FALSE(run.add(1, at(8))) << "it comes twice";
  EXPECT_FALSE(run.add(1, at(4)));
}

TEST(PacketRun, GivesUpWhatIsMissingBeforeATimeAndNothingBehindIt) {
  PacketRun run;
  for (const std::uint32_t sequence : {1U, 3U, 4U, 6U}) run.add(sequence, at(10 * sequence));
  run.give_up(at(25));
  EXPECT_EQ(run.whole_until(), at(40)) << "3 holds it, and 4 was there";
  run.give_up(at(40));
  EXPECT_EQ(run.whole_until(), at(40));
  run.give_up(at(500));
  EXPECT_EQ(run.whole_until(), at(60));
  run.add(5, at(50));  // Too late.
  run.add(7, at(70));
  EXPECT_EQ(run.whole_until(), at(70));
}

TEST(PacketRun, NumbersWrapAndBeginAnew) {
  PacketRun run;
  run.add(0xFFFFFFFE, at(10));
  run.add(0, at(30));
  EXPECT_EQ(run.whole_until(), at(10));
  run.add(0xFFFFFFFF, at(20));
  EXPECT_EQ(run.whole_until(), at(30));
  run.add(1000, at(40));
  EXPECT_EQ(run.whole_until(), at(40)) << "a thousand packets are not waited for";
  EXPECT_FALSE(run.add(1, at(35))) << "too far behind to tell";
  run.add(2, at(50));
  EXPECT_EQ(run.whole_until(), at(50)) << "numbers began anew";
}

TEST(PacketRun, RemembersNoMoreThanItCan) {
  PacketRun run;
  run.add(1, at(1));
  for (std::uint32_t sequence = 3; sequence < 100; ++sequence) run.add(sequence, at(sequence));
  EXPECT_GE(run.whole_until(), at(64));
}

}  // namespace
}  // namespace mien::sensor::packet_run_test
