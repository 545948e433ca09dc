#include "mien/take/session_log.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/take/example_take.h"

namespace mien::take::session_log_test {
namespace {

LogEntry entry(std::int64_t id) {
  return {id, test::host_ms(id), "udp", {}};
}
StoredSample sample(std::int64_t entry_id, std::uint32_t sequence) {
  StoredSample stored;
  stored.entry = entry_id;
  stored.sample.sequence = sequence;
  return stored;
}
Tick tick(std::int64_t index, std::int64_t after) {
  return {index, after, {}, {}};
}

/// "e1 e2 t0 ...": what a replay sees; samples by their sequence number.
template <class Order>
std::string spell(const Order& order) {
  std::string text;
  for (const auto& step : order) {
    EXPECT_NE(step.item == nullptr, step.tick == nullptr);
    if (!text.empty()) text += ' ';
    if (step.tick != nullptr)
      text += "t" + std::to_string(step.tick->index);
    else if constexpr (requires { step.item->id; })
      text += "e" + std::to_string(step.item->id);
    else
      text += "s" + std::to_string(step.item->sample.sequence);
  }
  return text;
}

TEST(ReplayOrder, PutsEachTickAfterItsEntry) {
  const std::vector entries = {entry(1), entry(2), entry(3)};
  const std::vector ticks = {tick(0, 0), tick(1, 2), tick(2, 2), tick(3, 3), tick(4, 3)};
  EXPECT_EQ(spell(replay_order(entries, ticks)), "t0 e1 e2 t1 t2 e3 t3 t4");
}

TEST(ReplayOrder, KeepsTheSamplesOfAnEntryTogetherBeforeItsTick) {
  // Entry 2 decoded to nothing, entry 3 to two samples; sample 9 came without an entry.
  const std::vector samples = {sample(0, 9), sample(1, 10), sample(3, 11), sample(3, 12), sample(4, 13)};
  const std::vector ticks = {tick(0, 0), tick(1, 2), tick(2, 3), tick(3, 9)};
  EXPECT_EQ(spell(replay_order(samples, ticks)), "s9 t0 s10 t1 s11 s12 t2 s13 t3");
}

TEST(ReplayOrder, IsEmptyOfNothing) {
  EXPECT_EQ(spell(replay_order(std::span<const LogEntry>(), {})), "");
  EXPECT_EQ(spell(replay_order(std::span<const StoredSample>(), {})), "");
}

TEST(ReplayOrder, IsTheSameFromTheLogAndFromTheSamples) {
  const mien::test::Folder folder;
  test::write_example(folder / "a.mien", 500);
  const auto take = Take::open(folder / "a.mien");
  ASSERT_TRUE(take);
  const auto entries = take->entries().value();
  const auto samples = take->samples().value();
  const auto ticks = take->ticks().value();
  // In this take each entry holds one sample, whose sequence number is the entry's id.
  std::string from_log = spell(replay_order(entries, ticks));
  for (char& letter : from_log)
    if (letter == 'e') letter = 's';
  EXPECT_EQ(from_log, spell(replay_order(samples, ticks)));
  EXPECT_THAT(from_log, ::testing::StartsWith("s1 s2"));
  EXPECT_THAT(from_log, ::testing::HasSubstr("s16 t1 s17"));
}

}  // namespace
}  // namespace mien::take::session_log_test
