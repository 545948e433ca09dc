#include "mien/model/correction_json.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::model::correction_json_test {
namespace {

constexpr std::size_t kInputs = 256;

Correction drawn() {
  Random random(3);
  Correction correction{.network = "0123456789abcdef", .weights = {}, .bias = {}};
  // As large as learnt ones are (docs/experiments/phone_truth.md).
  for (std::size_t i = 0; i < face::kShapeCount * kInputs; ++i)
    correction.weights.push_back(static_cast<float>(random.normal(0, 0.005)));
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    correction.bias.push_back(static_cast<float>(random.normal(0, 0.02)));
  return correction;
}

TEST(CorrectionJson, ComesBackAsItWasRounded) {
  const Correction exact = drawn(), correction = rounded_as_written(exact);
  const auto back = parse_correction(write_correction(correction), "here");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, correction);
  EXPECT_EQ(rounded_as_written(correction), correction) << "once is enough";
  for (std::size_t i = 0; i < correction.weights.size(); ++i)
    ASSERT_NEAR(correction.weights[i], exact.weights[i], 5.1e-6);
  for (std::size_t i = 0; i < correction.bias.size(); ++i)
    ASSERT_NEAR(correction.bias[i], exact.bias[i], 5.1e-6);
  EXPECT_LT(write_correction(correction).size(), 80U << 10U) << "as a command it must fit";
}

TEST(CorrectionJson, RefusesEachMistakeAlone) {
  const auto zeros = [](std::size_t count, const std::string& first = "0") {
    std::string list = first;
    for (std::size_t i = 1; i < count; ++i) list += ",0";
    return list;
  };
  const auto code = [](const std::string& json) {
    const auto parsed = parse_correction(json, "here");
    return parsed ? std::optional<ErrorCode>() : parsed.error().code;
  };
  const auto with = [](const std::string& numbers, const std::string& network = R"("0123456789abcdef")") {
    return R"({"network": )" + network + R"(, "hundred_thousandths": [)" + numbers + "]}";
  };
  constexpr std::size_t kCount = face::kShapeCount * 3;
  EXPECT_FALSE(code(with(zeros(kCount))));
  EXPECT_EQ(code("no JSON"), ErrorCode::malformed);
  EXPECT_EQ(code("{}"), ErrorCode::malformed);
  EXPECT_EQ(code(with(zeros(kCount), "7")), ErrorCode::malformed);
  EXPECT_EQ(code(with(zeros(kCount), R"("0123")")), ErrorCode::malformed);
  EXPECT_EQ(code(with(zeros(kCount), R"("0123456789abcdeg")")), ErrorCode::malformed);
  EXPECT_EQ(code(with("")), ErrorCode::mismatch);
  EXPECT_EQ(code(with(zeros(face::kShapeCount))), ErrorCode::mismatch) << "there is no bias alone";
  EXPECT_EQ(code(with(zeros(kCount + 1))), ErrorCode::mismatch);
  EXPECT_EQ(code(with(zeros(face::kShapeCount * 4098))), ErrorCode::mismatch);
  EXPECT_EQ(code(with(zeros(kCount, "0.5"))), ErrorCode::malformed);
  EXPECT_EQ(code(with(zeros(kCount, "1000001"))), ErrorCode::out_of_range);
  EXPECT_EQ(code(with(zeros(kCount, "18446744073709551615"))), ErrorCode::out_of_range);
  EXPECT_EQ(code(with(zeros(kCount, "\"a\""))), ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::model::correction_json_test
