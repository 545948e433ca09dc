// `mien export --model` and `mien bench onnxruntime`.
#include <gmock/gmock.h>
#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "mien/model/model_file.h"
#include "tests/app/program.h"
#include "tests/model/random_network.h"
#include "tests/project_path.h"

namespace mien::app::test::onnx_test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

bool onnxruntime_installed() {
  return std::filesystem::exists(project_path("script/onnxruntime/node_modules/onnxruntime-node")) &&
         std::system("node --version > /dev/null 2>&1") == 0;
}

class Onnx : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(model::write_model(folder_ / "causal.safetensors", model::small_causal_model()));
    ASSERT_TRUE(model::write_model(folder_ / "window.safetensors", model::small_model()));
  }
  const Folder folder_;
};

TEST_F(Onnx, ExportsEveryPart) {
  const Outcome done = run({"export", "--model", folder_ / "causal.safetensors", "--chain", "3", "--features",
                            "--out", folder_ / "causal.onnx", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  const json told = json::parse(done.out);
  EXPECT_EQ(told.at("part"), "network");
  EXPECT_EQ(told.at("steps"), 3);
  EXPECT_EQ(told.at("bytes"), content(folder_ / "causal.onnx").size());
  const Outcome ridge = run({"export", "--model", folder_ / "window.safetensors", "--part", "ridge.lab",
                             "--out", folder_ / "ridge.onnx"});
  EXPECT_EQ(ridge.status, 0) << ridge.err;
  EXPECT_THAT(content(folder_ / "ridge.onnx"), HasSubstr("mien_ridge"));
}

TEST_F(Onnx, ThePeerIsMeasuredAndGivesOurAnswer) {
  if (!onnxruntime_installed()) GTEST_SKIP() << "no node, or no ONNX Runtime: run script/bootstrap";
  const Outcome done = run({"bench", "onnxruntime", "--model", folder_ / "causal.safetensors", "--model",
                            folder_ / "window.safetensors", "--rounds", "1", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  const json told = json::parse(done.out);
  ASSERT_EQ(told.at("models").size(), 2U);
  for (const json& model : told.at("models")) {
    EXPECT_EQ(model.at("hash").get<std::string>().size(), 64U);
    EXPECT_LE(model.at("largest_difference"), 1e-4);
    EXPECT_TRUE(model.at("step_us").is_number());
    EXPECT_EQ(model.at("graphs").size(), model.at("kind") == "causal" ? 4U : 1U);
  }
}

TEST_F(Onnx, WithoutNodeOneLineSaysWhatToInstall) {
  const char* path = ::getenv("PATH");
  const std::string before = path == nullptr ? "" : path;
  ::setenv("PATH", "/nonexistent", 1);
  const Outcome refused = run({"bench", "onnxruntime", "--model", folder_ / "causal.safetensors"});
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.out, "");
  EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("script/bootstrap"));
}

}  // namespace
}  // namespace mien::app::test::onnx_test
