// `mien bench attack` from outside: what a stranger cannot do, whatever the machine is busy with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::bench_attack_test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

json attack(std::vector<std::string> options) {
  options.insert(options.begin(), {"bench", "attack", "--brief", "--json"});
  const Outcome outcome = run(options);
  EXPECT_EQ(outcome.status, 0) << joined(options) << ": " << outcome.err << outcome.out;
  return json::parse(outcome.out, nullptr, false);
}

/// Of all sessions of a run: the devices were heard, nobody else was, and the take gives the same bits.
/// `pictures`: how many fewer of the good cameras' a busy machine may take.
void expect_held(const json& all, double pictures = 0) {
  ASSERT_FALSE(all.is_discarded());
  for (const json& half : all["sessions"]) {
    const double heard = half["nobody"]["median"]["heard"];
    EXPECT_GT(heard, 0);
    for (const json& row : half["attacks"]) {
      const json& figures = row["median"];
      EXPECT_EQ(row["verdict"], "held") << row.dump();
      EXPECT_GT(figures["sent"], 0) << row["attack"];
      EXPECT_GE(figures["heard"], heard - std::max(0.01 * heard, pictures)) << row["attack"];
      EXPECT_EQ(figures["strangers_heard"], 0) << row["attack"];
      EXPECT_EQ(figures["same_bits"], true) << row["attack"];
    }
  }
}

TEST(BenchAttack, DevicesAreHeardAndNobodyElse) {
  const json all = attack(
      {"--seconds", "2", "--still", "2", "--attack", "table", "--attack", "mutated", "--attack", "restart"});
  ASSERT_EQ(all["sessions"].size(), 2U);
  EXPECT_EQ(all["sessions"][0]["key"], false);
  EXPECT_EQ(all["sessions"][1]["key"], true);
  expect_held(all);
  // More senders than the table has places.
  EXPECT_GT(all["sessions"][0]["attacks"][0]["median"]["evicted"], 0);
}

TEST(BenchAttack, AFirstComerWhoseClockLeapsIsPutAsideAndGivesNoBacklog) {
  expect_held(attack({"--seconds", "2", "--still", "6", "--key", "without", "--attack", "leap-first"}));
}

TEST(BenchAttack, WhoBehavesAsASensorAndSpeaksFirstWinsWithoutAKeyAndNotWithOne) {
  const json all = attack({"--seconds", "2", "--still", "2", "--attack", "sensor-first"});
  const json &without = all["sessions"][0]["attacks"][0], &with = all["sessions"][1]["attacks"][0];
  EXPECT_EQ(without["verdict"], "only a key or a choice on the page");
  EXPECT_GT(without["median"]["strangers_heard"], 0);
  EXPECT_EQ(with["verdict"], "held");
  EXPECT_EQ(with["median"]["strangers_heard"], 0);
  EXPECT_GT(with["median"]["heard"], 0);
}

TEST(BenchAttack, AHostileCameraTakesNothingFromTheOthers) {
  const json all = attack({"--seconds", "3", "--attack", "camera-endless", "--attack", "camera-hostile",
                           "--attack", "camera-lengths"});
  ASSERT_EQ(all["sessions"].size(), 1U);
  EXPECT_EQ(all["sessions"][0]["boards"], "cameras");
  ASSERT_EQ(all["sessions"][0]["attacks"].size(), 3U);
  expect_held(all, 12);
}

TEST(BenchAttack, NamesItsAttacksWhereOneIsUnknown) {
  const Outcome outcome = run({"bench", "attack", "--attack", "flood"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--attack flood"));
  EXPECT_THAT(outcome.err, HasSubstr("sensor-first"));
}

TEST(BenchAttack, AttacksNobodyButThisMachine) {
  for (const char* address : {"udp://192.168.1.7:5005", "udp://0.0.0.0:5005", "127.0.0.1:5005",
                              "udp://127.0.0.1", "udp://localhost:5005"}) {
    const Outcome outcome = run({"bench", "attack", "--to", address});
    EXPECT_EQ(outcome.status, 2) << address;
    EXPECT_THAT(outcome.err, HasSubstr("only a session on this machine")) << address;
  }
  const Outcome sent =
      run({"bench", "attack", "--to", "udp://127.0.0.1:9", "--seconds", "1", "--rate", "0.1", "--json"});
  EXPECT_EQ(sent.status, 0) << sent.err;
  EXPECT_GT(json::parse(sent.out)["strangers"], 5);
}

}  // namespace
}  // namespace mien::app::test::bench_attack_test
