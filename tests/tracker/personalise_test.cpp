#include "mien/tracker/personalise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "tests/tracker/prompted_minute.h"

namespace mien::tracker::personalise_test {
namespace {

using test::kAsked;
using test::kNames;
using test::Minute;

TEST(Personalise, LearnsTheWearersSkin) {
  const Minute minute(1);
  model::ModelFile file = minute.model();
  const auto learnt = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_TRUE(learnt->taken);
  EXPECT_EQ(learnt->prompts, 30u);
  EXPECT_LT(learnt->surprise_after, learnt->surprise_before);
  EXPECT_LT(minute.left(file.skin->wearer), 0.8) << "how strongly it was done is not known";
}

TEST(Personalise, FindsSensorsByNameAndDoesWithoutTheMissing) {
  Minute minute(2);
  model::ModelFile whole = minute.model(), partly = minute.model();
  ASSERT_TRUE(personalise(minute.features, minute.prompts, kNames, whole));
  // Another order, and one sensor is away for the first half.
  std::vector<std::string> names = kNames;
  std::ranges::reverse(names);
  for (std::size_t f = 0; f < minute.features.size(); ++f) {
    std::ranges::reverse(minute.features[f].sensors);
    if (f < minute.features.size() / 2) minute.features[f].sensors[0].has_rotation = false;
  }
  ASSERT_TRUE(personalise(minute.features, minute.prompts, names, partly));
  EXPECT_LT(minute.left(partly.skin->wearer), 0.9);
  EXPECT_LT(minute.left(whole.skin->wearer), minute.left(partly.skin->wearer));
}

TEST(Personalise, KeepsTheModelWhenNothingIsForetoldBetter) {
  // The first time each shape is asked for somebody else answers: what is learnt of them is wrong of the
  // wearer, who is the standard.
  const Minute other(5, 1.5);
  Minute minute(3, 0);
  model::ModelFile file = minute.model();
  const std::size_t half = minute.features.size() / 2;
  for (std::size_t f = half; f < minute.features.size(); ++f) minute.features[f] = other.features[f];
  // Held out are prompts of the first half, learnt from mostly those of the second.
  const auto learnt = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_FALSE(learnt->taken);
  EXPECT_GT(learnt->surprise_after, learnt->surprise_before);
  EXPECT_TRUE(file.skin->wearer.empty());
}

TEST(Personalise, AnswersThatAreHeldUntilTheNextPromptAreUnderstood) {
  Minute minute(6);
  for (std::size_t p = 0; p < minute.prompts.size(); ++p) {
    minute.prompts[p].held = true;
    // Once it is reached it is held.
    for (std::size_t f = 120 * p + 70; f < 120 * (p + 1); ++f)
      minute.features[f].sensors = minute.features[120 * p + 69].sensors;
  }
  model::ModelFile held = minute.model();
  ASSERT_TRUE(personalise(minute.features, minute.prompts, kNames, held).value().taken);
  EXPECT_LT(minute.left(held.skin->wearer), 0.8);
}

TEST(Personalise, SaysWhatItMisses) {
  Minute minute(1);
  model::ModelFile file = minute.model();
  auto refused = personalise(minute.features, std::span(minute.prompts).first(5), kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found);
  refused = personalise(minute.features, std::span(minute.prompts).first(kAsked), kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found) << "nothing twice";
  refused = personalise(minute.features, minute.prompts, {"x", "y", "z", "w"}, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
  std::swap(file.shapes[3], file.shapes[4]);
  refused = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch) << "shapes in another order";
  file.skin.reset();
  refused = personalise(minute.features, minute.prompts, kNames, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mien::tracker::personalise_test
