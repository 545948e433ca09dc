// `mien bench start` from outside: what it prints, not how fast.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::bench_start_test {
namespace {

TEST(BenchStart, StartsSessionsUntilTheySendAndSaysHowLongItTook) {
  const Outcome outcome = run({"bench", "start", "--times", "1", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["starts"], 1);
  EXPECT_GT(json["program_alone"]["median_ms"], 0);
  for (const char* session : {"with_page", "without_page", "with_cameras"}) {
    EXPECT_GT(json[session]["median_ms"], 0) << session;
    EXPECT_LE(json[session]["median_ms"], json[session]["worst_ms"]) << session;
    EXPECT_GT(json[session]["peak_memory_mb"], 1) << session;
  }
}

}  // namespace
}  // namespace mien::app::test::bench_start_test
