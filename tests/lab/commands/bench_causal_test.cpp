// `mien bench causal` from outside: what it prints, not how fast.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "mien/model/model_file.h"
#include "tests/app/program.h"
#include "tests/tracker/tiny_model.h"

namespace mien::app::test::bench_causal_test {
namespace {

using ::testing::HasSubstr;

class BenchCausal : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(model::write_model(model_, tracker::test::tiny_causal_model({"mentalis", "buccinator_L"})));
  }
  [[nodiscard]] Outcome bench(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"bench", "causal", "--model", model_, "--frames", "3"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

 private:
  Folder folder_;

 protected:
  const std::string model_ = folder_ / "tiny.safetensors";
};

TEST_F(BenchCausal, GivesTheFieldsThatScriptsRelyOn) {
  for (const char* precision : {"fp32", "bf16", "int8"}) {
    std::vector<std::string> arguments = {"--precision", precision, "--json"};
    if (precision != std::string_view("fp32")) arguments.emplace_back("--no-peers");
    const Outcome outcome = bench(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(json["precision"], precision);
    EXPECT_EQ(json["frames"], 3);
    for (const char* number : {"p50_ms", "p99_ms", "peak_gflops", "performers_per_core", "hot_step_us"})
      EXPECT_GT(json[number].get<double>(), 0) << number;
    EXPECT_LE(json["p50_ms"], json["p99_ms"]);
    EXPECT_EQ(json["hash"].get<std::string>().size(), 64U);
    // A peer that is not here is nothing, and says why.
    for (const auto& [ratio, peer] :
         {std::pair{"vs_onnxruntime", "onnxruntime"}, {"vs_libtorch", "libtorch"}}) {
      ASSERT_TRUE(json.contains(ratio));
      EXPECT_EQ(json[ratio].is_null(), json.contains(peer)) << ratio;
    }
    const auto again = nlohmann::json::parse(bench({"--precision", precision, "--no-peers", "--json"}).out);
    EXPECT_EQ(again["hash"], json["hash"]) << "the same frames, the same bits";
  }
}

TEST_F(BenchCausal, TellsPeopleTheSame) {
  const Outcome outcome = bench({"--no-peers"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* said : {"p50", "p99", "GB/s", "performers that one core carries", "peak", "hash"})
    EXPECT_THAT(outcome.out, HasSubstr(said));
}

TEST_F(BenchCausal, RefusesAPrecisionThatThereIsNot) {
  const Outcome outcome = bench({"--precision", "fp8"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("fp8"));
  EXPECT_THAT(outcome.err, HasSubstr("choose fp32, bf16 or int8"));
}

}  // namespace
}  // namespace mien::app::test::bench_causal_test
