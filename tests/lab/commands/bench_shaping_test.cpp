// `mien bench shaping` from outside: what it prints, not how fast.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::bench_shaping_test {
namespace {

TEST(BenchShaping, MeasuresTheChainAndTheChainWithoutEachStep) {
  const auto measured = [] {
    const Outcome outcome = run({"bench", "shaping", "--frames", "600", "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto json = measured();
  EXPECT_GT(json["p50_us"], 0);
  EXPECT_LE(json["p50_us"], json["p99_us"]);
  EXPECT_EQ(json["without"].size(), 11U);
  for (const auto& [step, took] : json["without"].items())
    EXPECT_EQ(took["hash"] != json["hash"], step != "mend") << step << ": its frames are sound";
  EXPECT_NE(json["every_step_off"]["hash"], json["hash"]);
  EXPECT_EQ(measured()["hash"], json["hash"]);
}

}  // namespace
}  // namespace mien::app::test::bench_shaping_test
