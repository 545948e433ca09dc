#include "mien/face/rig_constraints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "mien/core/random.h"

namespace mien::face::rig_constraints_test {
namespace {

using ::testing::HasSubstr;

RigConstraints rules(const std::string& toml) {
  auto parsed = RigConstraints::parse(toml, "rules.toml");
  EXPECT_TRUE(parsed.has_value()) << parsed.error().message();
  return parsed ? *parsed : RigConstraints();
}

BlendshapeWeights random_face(Random& random) {
  BlendshapeWeights w;
  // Many zeros and ones, as on faces.
  for (float& x : w.values) x = static_cast<float>(std::clamp(random.uniform(-0.5, 1.5), 0.0, 1.0));
  return w;
}

TEST(RigConstraints, OfAnExclusivePairTheSmallerGivesUp) {
  const RigConstraints c = rules("[[exclusive]]\na = \"jawLeft\"\nb = \"jawRight\"\n");
  BlendshapeWeights w;
  w[shape("jawLeft")] = 0.3F;
  w[shape("jawRight")] = 0.4F;
  EXPECT_FALSE(c.obeyed(w));
  c.project(w);
  EXPECT_EQ(w[shape("jawLeft")], 0);
  EXPECT_EQ(w[shape("jawRight")], 0.4F);
  w[shape("jawLeft")] = 0.4F;
  c.project(w);
  EXPECT_EQ(w[shape("jawLeft")], 0.4F) << "of equal ones the second";
  EXPECT_EQ(w[shape("jawRight")], 0);
}

TEST(RigConstraints, AGroupComesWithinItsBandOfTheMean) {
  const std::string names = "[[together]]\nshapes = [\"eyeBlink_L\", \"eyeBlink_R\"]\n";
  BlendshapeWeights w;
  w[shape("eyeBlink_L")] = 1;
  rules(names).project(w);
  EXPECT_NEAR(w[shape("eyeBlink_L")], 0.5F, 1e-6) << "without a band: the mean";
  EXPECT_NEAR(w[shape("eyeBlink_R")], 0.5F, 1e-6);
  w[shape("eyeBlink_L")] = 1;
  w[shape("eyeBlink_R")] = 0;
  rules(names + "within = 0.2\n").project(w);
  EXPECT_NEAR(w[shape("eyeBlink_L")], 0.7F, 1e-6);
  EXPECT_NEAR(w[shape("eyeBlink_R")], 0.3F, 1e-6);
  // Of three the mean moves with each clip: 0.9, 0, 0 has mean 0.3, clipped to 0.4, 0.2, 0.2 has 0.267, and
  // so on to where the first is 0.1 from the mean of all.
  const RigConstraints three =
      rules("[[together]]\nshapes = [\"browInnerUp_L\", \"browInnerUp_R\", \"browDown_L\"]\nwithin = 0.1\n");
  w = {};
  w[shape("browInnerUp_L")] = 0.9F;
  three.project(w);
  EXPECT_TRUE(three.obeyed(w));
  const float mean = (w[shape("browInnerUp_L")] + w[shape("browInnerUp_R")] + w[shape("browDown_L")]) / 3;
  EXPECT_NEAR(w[shape("browInnerUp_L")] - mean, 0.1F, 1e-6);
}

TEST(RigConstraints, AConditionClipsByItsCurve) {
  const RigConstraints c = rules(
      "[[conditional]]\na = \"mouthClose\"\nb = \"jawOpen\"\nat_most = [[0.2, 0.1], [0.6, 0.5], [0.8, "
      "0.3]]\n");
  const auto left = [&](float jaw) {
    BlendshapeWeights w;
    w[shape("mouthClose")] = 1;
    w[shape("jawOpen")] = jaw;
    c.project(w);
    EXPECT_EQ(w[shape("jawOpen")], jaw);
    return w[shape("mouthClose")];
  };
  EXPECT_NEAR(left(0), 0.1F, 1e-6) << "level before the first point";
  EXPECT_NEAR(left(0.2F), 0.1F, 1e-6);
  EXPECT_NEAR(left(0.3F), 0.2F, 1e-6);
  EXPECT_NEAR(left(0.7F), 0.4F, 1e-6);
  EXPECT_NEAR(left(1), 0.3F, 1e-6) << "level after the last";
}

TEST(RigConstraints, AChainOfConditionsSettlesInWhateverOrderItIsWritten) {
  // Ten of them, the last written first: each is bounded by half of the next.
  std::string toml;
  for (int i = 0; i < 10; ++i)
    toml += "[[conditional]]\na = \"" + std::string(kShapeNames[static_cast<std::size_t>(i)]) + "\"\nb = \"" +
            std::string(kShapeNames[static_cast<std::size_t>(i) + 1]) + "\"\nat_most = [[0, 0], [1, 0.5]]\n";
  const RigConstraints c = rules(toml);
  BlendshapeWeights w;
  w.values.fill(1);
  c.project(w);
  EXPECT_EQ(w[10], 1);
  EXPECT_NEAR(w[9], 0.5F, 1e-6);
  EXPECT_NEAR(w[0], 0.5F * 0.5F / 256, 1e-6);
}

TEST(RigConstraints, ProjectionKeepsItsPromisesForAnyRulesThatLoad) {
  Random random(5);
  std::size_t loaded = 0;
  for (int set = 0; set < 60; ++set) {
    std::string toml;
    const auto name = [&] { return "\"" + std::string(kShapeNames[random.below(kShapeCount)]) + "\""; };
    const auto count = random.below(12);
    for (std::uint64_t k = 0; k < count; ++k) switch (random.below(3)) {
        case 0:
          toml += "[[exclusive]]\na = " + name() + "\nb = " + name() + "\n";
          break;
        case 1:
          toml += "[[together]]\nshapes = [" + name() + ", " + name() + ", " + name() +
                  "]\nwithin = " + std::to_string(random.uniform()) + "\n";
          break;
        default:
          toml += "[[conditional]]\na = " + name() + "\nb = " + name() + "\nat_most = [[0, " +
                  std::to_string(random.uniform()) + "], [1, " + std::to_string(random.uniform()) + "]]\n";
      }
    const auto parsed = RigConstraints::parse(toml, "random.toml");
    if (!parsed) continue;
    ++loaded;
    for (int i = 0; i < 400; ++i) {
      const BlendshapeWeights before = random_face(random);
      BlendshapeWeights once = before;
      parsed->project(once);
      ASSERT_TRUE(parsed->obeyed(once)) << toml;
      for (const float x : once.values) ASSERT_TRUE(x >= 0 && x <= 1);
      BlendshapeWeights twice = once;
      parsed->project(twice);
      ASSERT_EQ(std::memcmp(&once, &twice, sizeof once), 0) << "a face that obeys stays to the bit\n" << toml;
      ASSERT_TRUE(!parsed->obeyed(before) || before == once);
    }
  }
  EXPECT_GT(loaded, 20U);
}

TEST(RigConstraints, NaturalOnesLetFacesBeThatPeopleMake) {
  const RigConstraints& c = natural_constraints();
  EXPECT_EQ(c.exclusive().size(), 14U);
  EXPECT_EQ(c.together().size(), 2U);
  EXPECT_EQ(c.conditions().size(), 1U);
  BlendshapeWeights wink;
  wink[shape("eyeBlink_L")] = 1;
  wink[shape("mouthSmile_L")] = wink[shape("mouthSmile_R")] = 0.8F;
  BlendshapeWeights after = wink;
  c.project(after);
  EXPECT_EQ(after, wink);
  after[shape("mouthClose")] = 0.5F;
  c.project(after);
  EXPECT_EQ(after[shape("mouthClose")], 0) << "no jaw is open";
}

struct Refused {
  std::string toml, says;
  int line;
};

class RigConstraintsRefuse : public ::testing::TestWithParam<Refused> {};

TEST_P(RigConstraintsRefuse, InOneLineThatNamesThePlace) {
  const auto parsed = RigConstraints::parse(GetParam().toml, "rules.toml");
  ASSERT_FALSE(parsed.has_value());
  const std::string message = parsed.error().message();
  EXPECT_THAT(message, HasSubstr(GetParam().says));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  const std::string line = GetParam().line > 0 ? "line " + std::to_string(GetParam().line) : "";
  EXPECT_THAT(message, HasSubstr(line));
}

std::string many(int count) {
  std::string toml;
  for (int i = 0; i < count; ++i) toml += "[[exclusive]]\na = \"jawLeft\"\nb = \"jawRight\"\n";
  return toml;
}

INSTANTIATE_TEST_SUITE_P(
    Rules, RigConstraintsRefuse,
    ::testing::Values(
        Refused{"[[exclusive]]\na = \"jawLeft\"\nb = \"jawRihgt\"\n", "did you mean jawRight?", 3},
        Refused{"[[exclusive]]\na = \"jawLeft\"\nb = \"jawLeft\"\n", "stands twice", 3},
        Refused{"[[exclusive]]\na = \"jawLeft\"\n", "'b' is missing", 1},
        Refused{"[[exclusive]]\na = 3\nb = \"jawLeft\"\n", "'a' is missing, or names no shape", 2},
        Refused{"[[exclusiv]]\na = \"jawLeft\"\n", "unknown key 'exclusiv'", 1},
        Refused{"exclusive = 3\n", "no list of rules", 1}, Refused{"exclusive = [3]\n", "no table", 1},
        Refused{"[[together]]\nshapes = [\"jawLeft\"]\n", "two names or more", 2},
        Refused{"[[together]]\nshapes = [\"jawLeft\", \"jawOpen\", \"jawLeft\"]\n", "stands twice", 2},
        Refused{"[[together]]\nshapes = [\"jawLeft\", \"jawOpen\"]\nwithin = -0.1\n", "'within' is -0.1", 3},
        Refused{"[[together]]\nshapes = [\"jawLeft\", \"jawOpen\"]\nwithin = nan\n", "'within' is nan", 3},
        Refused{"[[conditional]]\na = \"jawLeft\"\nb = \"jawOpen\"\n", "'at_most' is no list", 1},
        Refused{"[[conditional]]\na = \"jawLeft\"\nb = \"jawOpen\"\nat_most = [[0, 0], [0, 1]]\n",
                "do not ascend", 4},
        Refused{"[[conditional]]\na = \"jawLeft\"\nb = \"jawOpen\"\nat_most = [[0, 2]]\n", "a most of a is 2",
                4},
        Refused{"[[conditional]]\na = \"jawLeft\"\nb = \"jawOpen\"\nat_most = [[0]]\n",
                "'at_most' is no list", 4},
        Refused{"[[conditional]]\na = \"jawLeft\"\nb = \"jawOpen\"\nat_most = [[0, 0]]\n"
                "[[conditional]]\na = \"jawOpen\"\nb = \"jawLeft\"\nat_most = [[0, 0]]\n",
                "is bounded by itself", 5},
        Refused{many(513), "513 rules are more than 512", 0}, Refused{many(10000), "10000 rules", 0},
        // One wants them alike, the other never both: no face with either but zeros.
        Refused{"[[exclusive]]\na = \"jawLeft\"\nb = \"jawRight\"\n[[together]]\nshapes = [\"jawLeft\", "
                "\"jawRight\"]\n"
                "within = 0.01\n",
                "fights with others", 0},
        Refused{"[[exclusive\n", "", 1}, Refused{std::string(2U << 20U, '#'), "bytes are more than", 0}));

}  // namespace
}  // namespace mien::face::rig_constraints_test
