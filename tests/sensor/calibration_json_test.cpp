#include "mien/sensor/calibration_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace mien::sensor::calibration_json_test {
namespace {

using nlohmann::json;

TEST(CalibrationJson, ScoresAreTakenBack) {
  const std::vector<Score> scores = {
      {.name = "nod", .value = 20.5, .unit = "deg", .pass = true, .sentence = "wide"},
      {.name = "light nose_R", .value = 0.1, .unit = "", .pass = false, .sentence = "dim"}};
  const auto back = read_scores(scores_json(scores), "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, scores);
  EXPECT_TRUE(read_scores(json::array(), "test")->empty());
}

TEST(CalibrationJson, WhatIsNoScoreIsNamed) {
  for (const char* bad : {R"([3])", R"([{"name": "nod"}])",
                          R"([{"name": "n", "value": "x", "unit": "", "pass": true, "sentence": ""}])",
                          R"([{"name": "n", "value": 1, "unit": "", "pass": 1, "sentence": ""}])"}) {
    const auto scores = read_scores(json::parse(bad), "test");
    ASSERT_FALSE(scores) << bad;
    EXPECT_EQ(scores.error().code, ErrorCode::malformed);
    EXPECT_NE(scores.error().message().find("score 0"), std::string::npos);
  }
}

TEST(CalibrationJson, ReadsEntriesOfTheirKindOnly) {
  const json object = {{"number", 2.5}, {"flag", true}, {"text", "x"}};
  double number = 0;
  bool flag = false;
  std::string text;
  EXPECT_TRUE(read_number(object, "number", number));
  EXPECT_TRUE(read_flag(object, "flag", flag));
  EXPECT_TRUE(read_string(object, "text", text));
  EXPECT_EQ(number, 2.5);
  EXPECT_TRUE(flag);
  EXPECT_EQ(text, "x");
  EXPECT_FALSE(read_number(object, "text", number));
  EXPECT_FALSE(read_number(object, "none", number));
  EXPECT_FALSE(read_flag(object, "number", flag));
  EXPECT_FALSE(read_string(object, "flag", text));
}

}  // namespace
}  // namespace mien::sensor::calibration_json_test
