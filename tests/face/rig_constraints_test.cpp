#include "mien/face/rig_constraints.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "tests/allocation_count.h"
#include "tests/project_path.h"

namespace mien::face::rig_constraints_test {
namespace {

using ::testing::HasSubstr;

RigConstraints parsed(const std::string& toml) {
  auto made = RigConstraints::parse(toml, "rules.toml");
  EXPECT_TRUE(made.has_value()) << made.error().message();
  return made ? *made : RigConstraints();
}

RuleSet rules(const std::string& toml) {
  return parsed(toml).live();
}

std::string exclusive(std::string_view a, std::string_view b) {
  return fmt::format("[[exclusive]]\na = \"{}\"\nb = \"{}\"\n", a, b);
}

std::string conditional(std::string_view a, std::string_view b, std::string_view at_most) {
  return fmt::format("[[conditional]]\na = \"{}\"\nb = \"{}\"\nat_most = {}\n", a, b, at_most);
}

std::string together(const std::vector<std::string_view>& shapes, double within) {
  std::string names;
  for (const std::string_view name : shapes) names += fmt::format("\"{}\", ", name);
  return fmt::format("[[together]]\nshapes = [{}]\nwithin = {}\n", names, within);
}

const std::string kLine = "[[0, 0], [1, 1]]";

BlendshapeWeights random_face(Random& random) {
  BlendshapeWeights w;
  // Many zeros and ones, as on faces.
  for (float& x : w.values) x = static_cast<float>(std::clamp(random.uniform(-0.5, 1.5), 0.0, 1.0));
  return w;
}

using Weights = std::vector<std::pair<std::string_view, float>>;

BlendshapeWeights face_of(const Weights& weights) {
  BlendshapeWeights face;
  for (const auto& [name, w] : weights) face[shape_index(name)] = w;
  return face;
}

/// The face after the rules is the one expected, and nothing else moved.
void expect_projected(const std::string& toml, const Weights& before, const Weights& after) {
  BlendshapeWeights face = face_of(before);
  rules(toml).project(face);
  const BlendshapeWeights expected = face_of(after);
  for (std::size_t i = 0; i < kShapeCount; ++i) EXPECT_NEAR(face[i], expected[i], 1e-6) << kShapeNames[i];
}

/// By how much a face is beyond the rules, found without the code that is tested.
double beyond(const RuleSet& set, const BlendshapeWeights& face) {
  double most = 0;
  for (const ExclusivePair& pair : set.exclusive)
    most = std::max(most, static_cast<double>(std::min(face[pair.a], face[pair.b])));
  for (const TogetherGroup& group : set.together) {
    double mean = 0;
    for (const std::size_t i : group.shapes)
      mean += static_cast<double>(face[i]) / static_cast<double>(group.shapes.size());
    for (const std::size_t i : group.shapes)
      most =
          std::max(most, std::abs(static_cast<double>(face[i]) - mean) - static_cast<double>(group.within));
  }
  for (const Condition& condition : set.conditions) {
    const double b = face[condition.b];
    const auto& points = condition.at_most;
    double bound = b < points.front().b ? points.front().a : points.back().a;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const auto &p = points[i - 1], &q = points[i];
      if (b >= p.b && b <= q.b) bound = std::lerp(p.a, q.a, (b - p.b) / (q.b - p.b));
    }
    most = std::max(most, static_cast<double>(face[condition.a]) - bound);
  }
  return most;
}

TEST(RigConstraints, OfAnExclusivePairTheSmallerGivesUp) {
  const RuleSet c = rules("[[exclusive]]\na = \"jawLeft\"\nb = \"jawRight\"\n");
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
  const RuleSet three =
      rules("[[together]]\nshapes = [\"browInnerUp_L\", \"browInnerUp_R\", \"browDown_L\"]\nwithin = 0.1\n");
  w = {};
  w[shape("browInnerUp_L")] = 0.9F;
  three.project(w);
  EXPECT_TRUE(three.obeyed(w));
  const float mean = (w[shape("browInnerUp_L")] + w[shape("browInnerUp_R")] + w[shape("browDown_L")]) / 3;
  EXPECT_NEAR(w[shape("browInnerUp_L")] - mean, 0.1F, 1e-6);
}

TEST(RigConstraints, AConditionClipsByItsCurve) {
  const RuleSet c = rules(
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

TEST(RigConstraints, ACurveRoundsToNothingBelowItsPoints) {
  const RigConstraints rules = parsed(conditional("jawLeft", "jawOpen", "[[0.94, 0.01], [1, 0]]"));
  BlendshapeWeights obeys = face_of({{"jawOpen", 1}});
  EXPECT_TRUE(rules.live().obeyed(obeys));
  const BlendshapeWeights before = obeys;
  rules.live().project(obeys);
  EXPECT_EQ(std::memcmp(&obeys, &before, sizeof before), 0);
  BlendshapeWeights breaks = face_of({{"jawOpen", 1}, {"jawLeft", 0.5F}});
  rules.live().project(breaks);
  EXPECT_EQ(breaks[shape("jawLeft")], 0);
  EXPECT_FALSE(std::signbit(breaks[shape("jawLeft")]));
}

TEST(RigConstraints, AChainOfConditionsSettlesInWhateverOrderItIsWritten) {
  // Ten of them, the last written first: each is bounded by half of the next.
  std::string toml;
  for (int i = 0; i < 10; ++i)
    toml += "[[conditional]]\na = \"" + std::string(kShapeNames[static_cast<std::size_t>(i)]) + "\"\nb = \"" +
            std::string(kShapeNames[static_cast<std::size_t>(i) + 1]) + "\"\nat_most = [[0, 0], [1, 0.5]]\n";
  const RuleSet c = rules(toml);
  BlendshapeWeights w;
  w.values.fill(1);
  c.project(w);
  EXPECT_EQ(w[10], 1);
  EXPECT_NEAR(w[9], 0.5F, 1e-6);
  EXPECT_NEAR(w[0], 0.5F * 0.5F / 256, 1e-6);
}

TEST(RigConstraints, AGroupDoesNotRaiseWhatOtherRulesHaveLowered) {
  // A condition on one of a group brings the others down with it: the mean is at most 0.4.
  expect_projected(together({"mouthSmile_L", "mouthSmile_R"}, 0.1) +
                       conditional("mouthSmile_L", "jawOpen", "[[0, 0.3], [1, 1]]"),
                   {{"mouthSmile_L", 0.6F}, {"mouthSmile_R", 0.6F}},
                   {{"mouthSmile_L", 0.3F}, {"mouthSmile_R", 0.5F}});
  // A lid that widens does not close, and the other one closes with it or not at all.
  expect_projected(exclusive("eyeBlink_L", "eyeWide_L") + together({"eyeBlink_L", "eyeBlink_R"}, 0),
                   {{"eyeBlink_L", 0.6F}, {"eyeWide_L", 0.7F}, {"eyeBlink_R", 0.9F}}, {{"eyeWide_L", 0.7F}});
  // Alike and never both: neither.
  expect_projected(exclusive("jawLeft", "jawRight") + together({"jawLeft", "jawRight"}, 0),
                   {{"jawLeft", 0.6F}, {"jawRight", 0.4F}}, {});
  // What a pair gives up is not there for a condition: funnel goes with the lesser pucker.
  expect_projected(
      conditional("mouthFunnel", "mouthPucker", kLine) + exclusive("mouthPucker", "mouthStretch_L"),
      {{"mouthFunnel", 0.9F}, {"mouthPucker", 0.4F}, {"mouthStretch_L", 0.5F}}, {{"mouthStretch_L", 0.5F}});
}

TEST(RigConstraints, ARuleIsForTheUsesThatItNames) {
  const std::string pair = exclusive("jawLeft", "jawRight");
  const auto counts = [](const RigConstraints& c) {
    return std::array{c.live().exclusive.size(), c.always().exclusive.size(), c.solve().exclusive.size()};
  };
  using Counts = std::array<std::size_t, 3>;
  EXPECT_EQ(counts(parsed(pair)), (Counts{1, 0, 1}));
  EXPECT_EQ(counts(parsed(pair + "in = [\"live\", \"solve\"]\n")), (Counts{1, 0, 1}));
  EXPECT_EQ(counts(parsed(pair + "in = [\"live\"]\n")), (Counts{1, 0, 0}));
  EXPECT_EQ(counts(parsed(pair + "in = [\"solve\"]\n")), (Counts{0, 0, 1}));
  EXPECT_EQ(counts(parsed(pair + "in = [\"solve\"]\nalways = false\n")), (Counts{0, 0, 1}));
  EXPECT_EQ(counts(parsed(pair + "always = true\n")), (Counts{1, 1, 1}));
  EXPECT_EQ(counts(parsed(pair + "always = true\nin = [\"live\"]\n")), (Counts{1, 1, 0}));
  // What the solver weighs against each other does not fight.
  const std::string half = conditional("jawLeft", "jawRight", "[[0, 0], [1, 0.5]]");
  EXPECT_FALSE(RigConstraints::parse(half + together({"jawLeft", "jawRight"}, 0.01), "rules.toml"));
  parsed(half + together({"jawLeft", "jawRight"}, 0.01) + "in = [\"solve\"]\n");
}

/// Rules drawn at random, of which many fight or go in circles.
std::string drawn_rules(Random& random) {
  std::string toml;
  const auto any = [&] { return kShapeNames[random.below(kShapeCount)]; };
  for (std::uint64_t i = random.below(8); i > 0; --i) toml += exclusive(any(), any());
  for (std::uint64_t i = random.below(3); i > 0; --i) {
    std::vector<std::string_view> shapes;
    for (std::uint64_t n = 2 + random.below(6); n > 0; --n) shapes.push_back(any());
    toml += together(shapes, random.chance(0.3) ? 0.0 : random.uniform(0, 0.4));
  }
  for (std::uint64_t i = random.below(8); i > 0; --i)
    toml +=
        conditional(any(), any(),
                    fmt::format("[[{}, {}], [{}, {}], [1.0, {}]]", random.uniform(0, 0.5), random.uniform(),
                                random.uniform(0.5, 1), random.uniform(), random.uniform()));
  return toml;
}

TEST(RigConstraints, ProjectionKeepsItsPromisesForAnyRulesThatLoad) {
  Random random(5);
  int faces = 0, moved = 0;
  for (int drawn = 0; drawn < 2000 && faces < 10'000; ++drawn) {
    const std::string toml = drawn_rules(random);
    const auto made = RigConstraints::parse(toml, "random.toml");
    if (!made) continue;
    const RuleSet& set = made->live();
    for (int i = 0; i < 200; ++i, ++faces) {
      const BlendshapeWeights before = random_face(random);
      BlendshapeWeights once = before;
      set.project(once);
      ASSERT_TRUE(set.obeyed(once)) << toml;
      ASSERT_LE(beyond(set, once), static_cast<double>(kRuleTolerance)) << toml;
      for (const float x : once.values) ASSERT_TRUE(x >= 0 && x <= 1);
      BlendshapeWeights twice = once;
      set.project(twice);
      ASSERT_EQ(std::memcmp(&once, &twice, sizeof once), 0) << "a face that obeys stays to the bit\n" << toml;
      ASSERT_TRUE(!set.obeyed(before) || before == once) << toml;
      moved += before == once ? 0 : 1;
    }
  }
  EXPECT_EQ(faces, 10'000);
  EXPECT_GT(moved, 5'000);
}

TEST(RigConstraints, AFaceThatObeysKeepsItsBits) {
  // Made to obey by hand, of rules that touch at their bounds: bands to the brim, weights at their limit.
  const RuleSet set =
      rules(exclusive("jawLeft", "jawRight") + together({"eyeBlink_L", "eyeBlink_R", "eyeWide_L"}, 0.05) +
            together({"cheekPuff_L", "cheekPuff_R"}, 0) + conditional("mouthClose", "jawOpen", kLine));
  Random random(12);
  for (int i = 0; i < 10'000; ++i) {
    BlendshapeWeights face = random_face(random);
    face[random.chance(0.5) ? shape("jawLeft") : shape("jawRight")] = 0;
    const double middle = random.uniform(0.1, 0.9);
    face[shape("eyeBlink_L")] = static_cast<float>(middle + 0.05);
    face[shape("eyeBlink_R")] = static_cast<float>(middle);
    face[shape("eyeWide_L")] = static_cast<float>(middle - 0.05);
    face[shape("cheekPuff_R")] = face[shape("cheekPuff_L")];
    face[shape("mouthClose")] = face[shape("jawOpen")];
    BlendshapeWeights kept = face;
    set.project(kept);
    ASSERT_EQ(std::memcmp(&kept, &face, sizeof face), 0);
  }
}

TEST(RigConstraints, WhatIsNoWeightIsBroughtIntoRangeFirst) {
  BlendshapeWeights face = face_of({{"jawLeft", std::numeric_limits<float>::quiet_NaN()},
                                    {"jawRight", 1e30F},
                                    {"mouthClose", std::numeric_limits<float>::infinity()},
                                    {"jawOpen", 0.4F},
                                    {"eyeBlink_L", -1e30F},
                                    {"eyeBlink_R", 1e30F}});
  const RuleSet set = rules(exclusive("jawLeft", "jawRight") + conditional("mouthClose", "jawOpen", kLine) +
                            together({"eyeBlink_L", "eyeBlink_R"}, 0));
  EXPECT_FALSE(set.obeyed(face));
  set.project(face);
  EXPECT_TRUE(set.obeyed(face));
  EXPECT_EQ(face, face_of({{"jawRight", 1},
                           {"mouthClose", 0.4F},
                           {"jawOpen", 0.4F},
                           {"eyeBlink_L", 0.5F},
                           {"eyeBlink_R", 0.5F}}));
}

TEST(RigConstraints, ProjectsWithoutAllocating) {
  const RuleSet set =
      rules(exclusive("jawLeft", "jawRight") + together({"eyeBlink_L", "eyeBlink_R", "eyeWide_L"}, 0.05) +
            conditional("mouthClose", "jawOpen", kLine));
  Random random(13);
  BlendshapeWeights face = random_face(random);
  const std::size_t before = mien::test::allocation_count();
  set.project(face);
  EXPECT_EQ(mien::test::allocation_count(), before);
}

TEST(RigConstraints, GoThroughTheirText) {
  const std::string toml = "# Br\xC3\xA9vity.\n" + exclusive("jawLeft", "jawRight") + "always = true\n";
  const RigConstraints made = parsed("\xEF\xBB\xBF" + toml);
  EXPECT_NE(made, RigConstraints());
  EXPECT_TRUE(std::ranges::all_of(made.text(), [](char c) { return static_cast<unsigned char>(c) < 0x80; }));
  const RigConstraints again = parsed(made.text());
  EXPECT_EQ(again, made);
  EXPECT_EQ(again.always().exclusive.size(), 1U);
  EXPECT_EQ(parsed(""), RigConstraints());
}

TEST(RigConstraints, NaturalOnesAreTheFileInTheFolder) {
  const auto read = RigConstraints::read(project_path("rigs/constraints/ict.toml"));
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(natural_constraints(), *read);
  EXPECT_EQ(RigConstraints::read("/nowhere/my.toml").error().code, ErrorCode::not_found);
}

TEST(RigConstraints, NaturalOnesLetFacesBeThatPeopleMake) {
  const RigConstraints& c = natural_constraints();
  EXPECT_EQ(c.live().exclusive.size(), 14U);
  EXPECT_EQ(c.live().together.size(), 0U);
  EXPECT_EQ(c.live().conditions.size(), 1U);
  EXPECT_EQ(c.always().exclusive.size() + c.always().together.size(), 0U);
  EXPECT_EQ(c.always().conditions.size(), 1U);
  EXPECT_EQ(c.solve().exclusive.size(), 14U);
  EXPECT_EQ(c.solve().together.size(), 2U);
  EXPECT_EQ(c.solve().conditions.size(), 1U);
  BlendshapeWeights wink = face_of({{"eyeBlink_L", 1}, {"mouthSmile_L", 0.8F}, {"mouthSmile_R", 0.8F}});
  BlendshapeWeights after = wink;
  c.live().project(after);
  EXPECT_EQ(after, wink);
  after[shape("mouthClose")] = 0.5F;
  c.always().project(after);
  EXPECT_EQ(after, wink) << "no jaw is open";
}

/// To the bit what stood in the code of the live chain before it was data.
TEST(RigConstraints, WhatAlwaysHoldsIsTheLesserOfMouthCloseAndJawOpen) {
  Random random(14);
  for (int i = 0; i < 10'000; ++i) {
    BlendshapeWeights face = random_face(random), expected = face;
    expected[shape("mouthClose")] = std::min(expected[shape("mouthClose")], expected[shape("jawOpen")]);
    natural_constraints().always().project(face);
    ASSERT_EQ(std::memcmp(&face, &expected, sizeof face), 0);
  }
}

struct Refused {
  std::string toml, says;
  int line;
};

class RigConstraintsRefuse : public ::testing::TestWithParam<Refused> {};

TEST_P(RigConstraintsRefuse, InOneLineThatNamesThePlace) {
  const auto made = RigConstraints::parse(GetParam().toml, "rules.toml");
  ASSERT_FALSE(made.has_value());
  const std::string message = made.error().message();
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
        Refused{many(513), "513 rules are more than 512", 3 * 512 + 1},
        Refused{many(10000), "10000 rules are more than 512", 3 * 512 + 1},
        Refused{many(512) + together({"jawOpen", "jawLeft"}, 0), "513 rules", 3 * 512 + 1},
        Refused{many(1) + "in = []\n", "'in' is no list of uses", 4},
        Refused{many(1) + "in = \"live\"\n", "'in' is no list of uses", 4},
        Refused{many(1) + "in = [\"live\", \"film\"]\n", "'in' is no list of uses", 4},
        Refused{many(1) + "always = 1\n", "'always' is not true or false", 4},
        Refused{many(1) + "in = [\"solve\"]\nalways = true\n", "no live one", 5},
        // Across uses, and of three: a rule that leads into the circle is no part of it.
        Refused{conditional("jawLeft", "mouthClose", kLine) + conditional("mouthClose", "jawOpen", kLine) +
                    "in = [\"live\"]\n" + conditional("jawOpen", "mouthFunnel", kLine) +
                    "in = [\"solve\"]\n" + conditional("mouthFunnel", "mouthClose", kLine),
                "is bounded by itself", 0},
        // Alike, and one at most half of the other.
        Refused{conditional("jawLeft", "jawRight", "[[0, 0], [1, 0.5]]") + exclusive("jawLeft", "mouthLeft") +
                    together({"jawLeft", "jawRight"}, 0) + "always = true\n",
                "fights with others", 8},
        Refused{"[[exclusive\n", "", 1}, Refused{std::string(2U << 20U, '#'), "bytes are more than", 0}));

}  // namespace
}  // namespace mien::face::rig_constraints_test
