#include "mien/headset/moment_features.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/headset/small_model.h"

namespace mien::headset::moment_features_test {
namespace {

MomentFeatures test_moment() {
  return {
      .features = {1, 2, 3, 4, 5, 6, 7, 8}, .present = {true, false, true, true}, .age_s = {0, 0, 0.05F, 5}};
}

TEST(MomentFeatures, AreReadAgainstTheFaceAtRestWhereBothAreKnown) {
  const RestFeatures rest{.features = {0.5F, 0.5F, 1, 1, 1, 1, 1, 1}, .present = {true, true, false, true}};
  std::vector<float> out(8, 9.0F);
  features_from_rest(test_moment(), rest, out);
  EXPECT_EQ(out, (std::vector<float>{0.5F, 1.5F, 0, 0, 0, 0, 6, 7}));
  features_from_rest(test_moment(), {}, out);
  EXPECT_EQ(out, std::vector<float>(8, 0.0F));
}

TEST(MomentFeatures, AreReadWithAgesWhatIsThereAndTheMomentsAnswer) {
  const auto model = test::small_model();
  const model::ViewsNetwork& network = model->network();
  model::ViewsNetwork::Workspace memory(network);
  MomentFeatures moment = test_moment();
  moment.features.clear();
  for (int i = 0; i < 32; ++i) moment.features.push_back(0.1F * static_cast<float>(i));
  std::vector<float> out(moment_condition(8)), answer(kAnswerOutputs), differences(32, 0.0F);
  ASSERT_EQ(out.size(), 32U + 32U + 9U + kAnswerOutputs);
  read_moment(network, moment, {}, memory, out);
  EXPECT_EQ(std::vector<float>(out.begin(), out.begin() + 32), moment.features);
  EXPECT_EQ(std::vector<float>(out.begin() + 64, out.begin() + 73),
            (std::vector<float>{0, 1, 0.5F, 1, 1, 0, 1, 1, 0}));
  network.answer(moment.features, differences, memory, answer);
  EXPECT_EQ(std::vector<float>(out.begin() + static_cast<std::ptrdiff_t>(moment_answer(8)), out.end()),
            answer);

  const RestFeatures rest{.features = std::vector<float>(32, 0.5F), .present = {true}};
  read_moment(network, moment, rest, memory, out);
  EXPECT_EQ(out[72], 1);
  EXPECT_EQ(out[33], moment.features[1] - 0.5F);
  for (std::size_t i = 0; i < 8; ++i) differences[i] = moment.features[i] - 0.5F;
  network.answer(moment.features, differences, memory, answer);
  EXPECT_EQ(std::vector<float>(out.begin() + 73, out.end()), answer);
}

TEST(MomentFeatures, AMemoryAddsToTheMomentsAnswerAsMuchAsItDoubts) {
  std::vector<float> condition(moment_condition(2), 9.0F);
  std::array<float, kMemoryOutputs> outputs{};
  for (std::size_t i = 0; i < kAnswerOutputs; ++i) condition[moment_answer(2) + i] = static_cast<float>(i);
  outputs.fill(0.5F);
  // Brows are surely right, the gaze surely wrong, of all else nothing is known.
  constexpr auto kBrows = static_cast<std::size_t>(face::ShapeRegion::brows);
  for (std::size_t j = 0; j < kJudgements; ++j)
    outputs[kAnswerOutputs + j] = j == kBrows ? 100.0F : j == kGazeJudgement ? -100.0F : 0.0F;
  add_moment_answer(condition, outputs);
  for (std::size_t i = 0; i < kAnswerOutputs; ++i) {
    const std::size_t judgement = judgement_of(i);
    const float share = judgement == kBrows ? 0.0F : judgement == kGazeJudgement ? 1.0F : 0.5F;
    EXPECT_FLOAT_EQ(outputs[i], static_cast<float>(i) + share * 0.5F) << i;
  }
  EXPECT_EQ(outputs[kAnswerOutputs + kBrows], 100.0F) << "a judgement is the memory's alone";
}

TEST(Judgements, DoubtTheOutputsThatTheyAreAbout) {
  for (std::size_t j = 0; j < kJudgements; ++j)
    for (const std::size_t output : judged_outputs()[j]) EXPECT_EQ(judgement_of(output), j);
  for (std::size_t i = 0; i < kAnswerOutputs; ++i) EXPECT_LT(judgement_of(i), kJudgements);
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
