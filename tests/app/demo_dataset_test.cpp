// `mien demo --record-dataset` from outside: a session, a virtual performer and a virtual phone in, a dataset
// out.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::demo_dataset_test {
namespace {

using Json = nlohmann::json;

TEST(DemoDatasetLiveProgram, RecordsATakeWithConsentLabelsTruthAndSound) {
  if (!std::filesystem::exists(std::filesystem::path(program_path()).parent_path() / "mien-media"))
    GTEST_SKIP() << "built without mien-media, which reads aloud";
  const Folder folder;
  const Outcome demo =
      run({"demo", "--record-dataset", "--out", folder / "demo", "--page", "127.0.0.1:0", "--json"});
  ASSERT_EQ(demo.status, 0) << demo.err;
  const Json recorded = Json::parse(demo.out, nullptr, false);
  ASSERT_TRUE(recorded.is_object()) << demo.out;
  EXPECT_EQ(recorded["lines"], 12);
  const Outcome listed = run({"dataset", recorded["dataset"].get<std::string>(), "--json"});
  ASSERT_EQ(listed.status, 0) << listed.err;
  const Json dataset = Json::parse(listed.out, nullptr, false);
  ASSERT_EQ(dataset["takes"].size(), 1U) << listed.out;
  EXPECT_EQ(dataset["people"][0]["name"], "virtual 2026");
  EXPECT_EQ(dataset["takes"][0]["truth"], "phone");
  EXPECT_EQ(dataset["left_out"].size(), 0U) << listed.out;
}

}  // namespace
}  // namespace mien::app::test::demo_dataset_test
