#include "mien/solve/prompted.h"

#include <gtest/gtest.h>

#include "mien/performer/prologue.h"
#include "mien/solve/solve.h"
#include "tests/solve/performed_take.h"
#include "tests/tracker/tiny_model.h"

namespace mien::solve::prompted_test {
namespace {

take::Event prompt(const std::string& json, double begin_s = 1, double end_s = 3) {
  return {"prompt", DeviceTime(from_seconds(begin_s)), DeviceTime(from_seconds(end_s)), json};
}

TEST(Prompted, ReadsWhatWasAskedForAndPassesOverTheRest) {
  const std::vector<take::Event> events = {
      {"neutral", DeviceTime{}, DeviceTime(from_seconds(1)), ""},
      prompt(
          R"({"name": "jawOpen", "rise_s": 0.3, "target": {"jawOpen": 1, "tongueOut": 1, "mouthFunnel": 2}})"),
      prompt(R"({"target": {"jawOpen": 0.5}})"),
      prompt(R"({"name": "rest", "target": {}})"),
      prompt("{"),
      prompt(R"({"target": {"jawOpen": "1"}})"),
      prompt(R"({"target": {"jawOpen": 1}, "rise_s": 5})")};
  const auto prompts = prompted_expressions(events);
  ASSERT_EQ(prompts.size(), 2u);
  EXPECT_EQ(prompts[0].name, "jawOpen");
  EXPECT_EQ(prompts[0].rise_s, 0.3);
  EXPECT_EQ(prompts[0].target[face::shape("jawOpen")], 1);
  EXPECT_EQ(prompts[0].target[face::shape("mouthFunnel")], 1) << "held to the range";
  EXPECT_FALSE(prompts[0].held);
  EXPECT_TRUE(prompts[1].held) << "shown until its end, as mien record does";
  EXPECT_EQ(prompts[1].target[face::shape("jawOpen")], 0.5F);
}

/// A virtual performer with a full prologue, whose chin turns by 0.3 and whose cheek by 0.5.
TEST(Prompted, AWearerIsLearntFromAVirtualPrologue) {
  const mien::test::Folder folder;
  const performer::PrologueMotion motion = performer::with_prologue(
      virt::test::talking(60, false), performer::PrologueKind::full, Random(3), {.gestures = false});
  const take::Take take = test::stored(
      virt::play_lab(motion, virt::test::three_sites(), virt::test::three_sensors(), Random(11)).value(),
      folder / "minute.mien", "lab");
  model::ModelFile file = tracker::test::tiny_causal_model({"mentalis", "buccinator_L"});
  const auto features = take_features(take).value();
  const auto refused = personalise_on(take, features, file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);

  const std::size_t chin = face::shape("jawOpen"),
                    cheek = face::kShapeCount * 3 + face::shape("mouthSmile_L");
  file.skin = model::Skin{.standard = std::vector<float>(6 * face::kShapeCount, 0.0F),
                          .covariance = std::vector<float>(face::kShapeCount * face::kShapeCount, 0.0F),
                          .wearer = {}};
  file.skin->standard[chin] = 0.2F;
  file.skin->standard[cheek] = 0.7F;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    file.skin->covariance[k * face::kShapeCount + k] = 0.02F;
  const auto learnt = personalise_on(take, features, file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_TRUE(learnt->taken);
  EXPECT_GT(learnt->prompts, 30u);
  EXPECT_NEAR(file.skin->wearer[chin], 0.3, 0.06);
  EXPECT_NEAR(file.skin->wearer[cheek], 0.5, 0.15) << "it was 0.7; how strongly it was done is not known";
}

}  // namespace
}  // namespace mien::solve::prompted_test
