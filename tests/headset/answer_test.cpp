#include "mien/headset/answer.h"

#include <gtest/gtest.h>

#include <array>

namespace mien::headset::answer_test {
namespace {

TEST(Answer, GoesThereAndBack) {
  Answer answer;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) answer.weights[k] = 0.01F * static_cast<float>(k);
  answer.tongue_out = 0.4F;
  answer.gaze_rad = {0.3F, -0.2F, 0.1F, 0.25F};
  answer.openness = {0.2F, 1.2F};
  answer.pupil_mm = {3, 5.5F};
  std::array<float, kAnswerOutputs> outputs{};
  encode_answer(answer, outputs);
  const Answer back = decode_answer(outputs);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) EXPECT_NEAR(back.weights[k], answer.weights[k], 1e-6);
  EXPECT_NEAR(back.tongue_out, 0.4, 1e-6);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(back.gaze_rad[i], answer.gaze_rad[i], 1e-6);
  for (std::size_t e = 0; e < 2; ++e) {
    EXPECT_NEAR(back.openness[e], answer.openness[e], 1e-6);
    EXPECT_NEAR(back.pupil_mm[e], answer.pupil_mm[e], 1e-6);
  }
}

TEST(Answer, IsHeldToWhatCanBe) {
  std::array<float, kAnswerOutputs> outputs{};
  outputs.fill(9);
  const Answer most = decode_answer(outputs);
  EXPECT_EQ(most.weights[0], 1);
  EXPECT_EQ(most.openness[0], 1.5F);
  EXPECT_EQ(most.pupil_mm[1], 8);
  EXPECT_LT(most.gaze_rad[0], 1.2F);
  outputs.fill(-9);
  const Answer least = decode_answer(outputs);
  EXPECT_EQ(least.tongue_out, 0);
  EXPECT_EQ(least.openness[1], 0);
}

TEST(Answer, MirrorsTwiceToItself) {
  const auto& places = mirrored_outputs();
  for (std::size_t i = 0; i < kAnswerOutputs; ++i) {
    ASSERT_LT(places[i], kAnswerOutputs);
    EXPECT_EQ(places[places[i]], i);
  }
  EXPECT_EQ(places[face::shape("mouthSmile_L")], face::shape("mouthSmile_R"));
  EXPECT_EQ(places[face::shape("jawLeft")], face::shape("jawRight"));
  EXPECT_EQ(places[face::shape("mouthRight")], face::shape("mouthLeft"));
  EXPECT_EQ(places[face::shape("jawOpen")], face::shape("jawOpen"));
  EXPECT_EQ(places[kGazeOutput], kGazeOutput + 2);
  EXPECT_TRUE(mirrors_sign(kGazeOutput));
  EXPECT_FALSE(mirrors_sign(kGazeOutput + 1));
}

}  // namespace
}  // namespace mien::headset::answer_test
