#include "mien/headset/moment_features.h"

#include <gtest/gtest.h>

#include <vector>

namespace mien::headset::moment_features_test {
namespace {

MomentFeatures moment() {
  return {
      .features = {1, 2, 3, 4, 5, 6, 7, 8}, .present = {true, false, true, true}, .age_s = {0, 0, 0.05F, 5}};
}

TEST(MomentFeatures, AreReadAgainstTheFaceAtRestWhereBothAreKnown) {
  const RestFeatures rest{.features = {0.5F, 0.5F, 1, 1, 1, 1, 1, 1}, .present = {true, true, false, true}};
  std::vector<float> out(8, 9.0F);
  features_from_rest(moment(), rest, out);
  EXPECT_EQ(out, (std::vector<float>{0.5F, 1.5F, 0, 0, 0, 0, 6, 7}));
  features_from_rest(moment(), {}, out);
  EXPECT_EQ(out, std::vector<float>(8, 0.0F));
}

TEST(MomentFeatures, AreWrittenWithAgesAndWhatIsThere) {
  std::vector<float> out(moment_condition(2));
  ASSERT_EQ(out.size(), 25U);
  write_moment_condition(moment(), {}, out);
  EXPECT_EQ(std::vector<float>(out.begin(), out.begin() + 8), moment().features);
  EXPECT_EQ(std::vector<float>(out.begin() + 16, out.end()),
            (std::vector<float>{0, 1, 0.5F, 1, 1, 0, 1, 1, 0}));
  write_moment_condition(moment(), {.features = std::vector<float>(8, 0.0F), .present = {true}}, out);
  EXPECT_EQ(out.back(), 1);
  EXPECT_EQ(out[8], 1);
}

TEST(Judgements, AreOfEveryShapeOnceAndOfTheGaze) {
  std::vector<int> times(kAnswerOutputs);
  for (const auto& outputs : judged_outputs())
    for (const std::size_t output : outputs) ++times[output];
  for (std::size_t k = 0; k < face::kShapeCount; ++k) EXPECT_EQ(times[k], 1) << face::kShapeNames[k];
  EXPECT_EQ(judged_outputs()[kGazeJudgement].size(), 4U);
  EXPECT_FLOAT_EQ(right_output_error(0), 0.2F) << "of outputs from -1 to 1";
  EXPECT_NEAR(right_output_error(kGazeJudgement), 0.1 / 0.7, 1e-6);
}

}  // namespace
}  // namespace mien::headset::moment_features_test
