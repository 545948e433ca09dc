// `mien bench headset` from outside: what it prints, not how fast.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::bench_headset_test {
namespace {

using ::testing::HasSubstr;

TEST(BenchHeadset, GivesTheFieldsThatScriptsRelyOn) {
  const Outcome outcome = run({"bench", "headset", "--frames", "3", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_GT(json["peak_gflops"], 0);
  EXPECT_GT(json["pictures_per_s"].get<double>(), 0);
  EXPECT_GT(json["vs_single_rays"].get<double>(), 0);
  EXPECT_EQ(json.at("vs_rivals").is_null(), json.contains("onnxruntime"));
  EXPECT_EQ(json["precision"], "int8");
  EXPECT_EQ(json["hash"].get<std::string>().size(), 64U);
  EXPECT_EQ(json["vs_onnxruntime"].is_null(), json.contains("onnxruntime"));
  const auto& encoder = json["encoder"];
  EXPECT_EQ(encoder["views"], 4);
  EXPECT_EQ(encoder["size"], 96);
  ASSERT_EQ(encoder["precisions"].size(), 3U);
  for (const auto& precision : encoder["precisions"]) {
    for (const char* number : {"p50_ms", "p99_ms", "hot_ms", "hot_p50_ms", "hot_p99_ms", "gflops"})
      EXPECT_GT(precision[number].get<double>(), 0) << number;
    EXPECT_EQ(precision["hash"].get<std::string>().size(), 64U);
    // A peer that is not here is nothing, and says why.
    EXPECT_EQ(precision.at("vs_onnxruntime").is_null(), json.contains("onnxruntime"));
  }
  const auto again =
      nlohmann::json::parse(run({"bench", "headset", "--frames", "1", "--no-peers", "--json"}).out);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(again["encoder"]["precisions"][i]["hash"], encoder["precisions"][i]["hash"])
        << "the same weights and pictures, the same bits";
  EXPECT_EQ(again["onnxruntime"], "not asked for");
}

TEST(BenchHeadset, TellsPeopleTheSame) {
  const Outcome outcome = run({"bench", "headset", "--frames", "1", "--no-peers"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* said : {"4 views of 96 x 96", "fp32", "bf16", "int8", "cold p50", "ONNX Runtime"})
    EXPECT_THAT(outcome.out, HasSubstr(said));
}

}  // namespace
}  // namespace mien::app::test::bench_headset_test
