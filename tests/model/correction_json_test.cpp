#include "mien/model/correction_json.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::model::correction_json_test {
namespace {

Correction drawn() {
  Random random(3);
  Correction correction{.lags = {0, 3, 9}, .weights = {}};
  for (std::size_t i = 0; i < face::kShapeCount * 3 * face::kShapeCount; ++i)
    correction.weights.push_back(static_cast<float>(random.normal()));
  return correction;
}

TEST(CorrectionJson, ComesBackAsItWasRounded) {
  const Correction exact = drawn(), correction = rounded_as_written(exact);
  const auto back = parse_correction(write_correction(correction), "here");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, correction);
  EXPECT_EQ(rounded_as_written(correction), correction) << "once is enough";
  for (std::size_t i = 0; i < correction.weights.size(); ++i)
    ASSERT_NEAR(correction.weights[i], exact.weights[i], 5.1e-5);
  EXPECT_LT(write_correction(correction).size(), 64U << 10U) << "as a command it must fit";
}

TEST(CorrectionJson, RefusesEachMistakeAlone) {
  const std::string zeros = [] {
    std::string list = "0";
    for (std::size_t i = 1; i < face::kShapeCount * face::kShapeCount; ++i) list += ",0";
    return list;
  }();
  const auto code = [](const std::string& json) {
    const auto parsed = parse_correction(json, "here");
    return parsed ? std::optional<ErrorCode>() : parsed.error().code;
  };
  const auto with = [&zeros](const std::string& lags, std::string weights = "") {
    if (weights.empty()) weights = zeros;
    return R"({"lags": )" + lags + R"(, "ten_thousandths": [)" + weights + "]}";
  };
  EXPECT_FALSE(code(with("[0]")));
  EXPECT_EQ(code("no JSON"), ErrorCode::malformed);
  EXPECT_EQ(code("{}"), ErrorCode::malformed);
  EXPECT_EQ(code(with("[]")), ErrorCode::malformed);
  EXPECT_EQ(code(with("[0.5]")), ErrorCode::malformed);
  EXPECT_EQ(code(with("[-1]")), ErrorCode::malformed);
  EXPECT_EQ(code(with("[1]")), ErrorCode::out_of_range);
  EXPECT_EQ(code(with("[0, 0]")), ErrorCode::out_of_range);
  EXPECT_EQ(code(with("[0, 61]")), ErrorCode::out_of_range);
  EXPECT_EQ(code(with("[0, 3]")), ErrorCode::mismatch);
  EXPECT_EQ(code(with("[0]", "1, 2")), ErrorCode::mismatch);
  EXPECT_EQ(code(with("[0]", "0.5" + zeros.substr(1))), ErrorCode::malformed);
  EXPECT_EQ(code(with("[0]", "1000001" + zeros.substr(1))), ErrorCode::out_of_range);
  EXPECT_EQ(code(with("[0]", "\"a\"" + zeros.substr(1))), ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::model::correction_json_test
