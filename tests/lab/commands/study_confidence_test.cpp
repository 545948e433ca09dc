#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/project_path.h"

namespace mien::app::test::study_confidence_test {
namespace {

TEST(StudyConfidence, ChoosesPeopleAndSensorsByTheModelFile) {
  const test::Outcome done =
      test::run({"study", "confidence", "--model", project_path("models/eyewear.safetensors"), "--performers",
                 "2", "--faulty", "1", "--seconds", "11", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  const auto json = nlohmann::json::parse(done.out);
  EXPECT_EQ(json.at("rig"), "eyewear");
  ASSERT_EQ(json.at("rows").size(), 12U) << "people like those of training, of other kinds, and both";
  EXPECT_EQ(json.at("rows").at(4).at("who"), "2 of other kinds");
  EXPECT_EQ(json.at("rows").at(8).at("who"), "4 of both kinds");
  for (const auto& row : json.at("rows")) {
    EXPECT_EQ(row.at("gaze_measured"), 0);
    EXPECT_EQ(row.at("measured"), 0) << "glasses explain too little of a wearer whom their model never saw";
    EXPECT_LE(row.at("ece_single").at("least"), row.at("ece_single").at("median"));
    EXPECT_LE(row.at("ece_single").at("median"), row.at("ece_single").at("most"));
  }
}

}  // namespace
}  // namespace mien::app::test::study_confidence_test
