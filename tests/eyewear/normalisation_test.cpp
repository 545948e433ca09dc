#include "mien/eyewear/normalisation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/eyewear/glasses.h"

namespace mien::eyewear::normalisation_test {
namespace {

GridLight lights(double a, double b, bool b_there = true) {
  return {{a, b}, {1, static_cast<std::uint8_t>(b_there ? 1 : 0)}, {0, 0}};
}

const sensor::Score* score(const Normalisation& made, std::string_view name) {
  const auto found = std::ranges::find(made.scores, name, &sensor::Score::name);
  return found == made.scores.end() ? nullptr : &*found;
}

/// A hold with a blink, and a range of motion in which the first sensor moves a lot and the second does not.
NormalisationMaker gathered() {
  NormalisationMaker maker(test::glasses_rig(2));
  maker.begin(StretchKind::neutral);
  for (int i = 0; i < 300; ++i)
    maker.add(StretchKind::neutral, lights(i % 60 < 8 ? -0.5 : -2 + 0.01 * (i % 3), -3));
  maker.begin(StretchKind::range);
  for (int i = 0; i < 1200; ++i)
    maker.add(StretchKind::range, lights(-2 + 0.8 * std::sin(0.02 * i), -3 + 0.001 * (i % 2)));
  return maker;
}

TEST(Normalisation, ABlinkInTheHoldLeavesNoTrace) {
  const Normalisation made = gathered().solve({});
  ASSERT_TRUE(made.complete);
  ASSERT_EQ(made.sensors.size(), 2u);
  EXPECT_NEAR(made.sensors[0].neutral, -1.99, 0.011);
  EXPECT_NEAR(made.sensors[1].neutral, -3, 1e-12);
  EXPECT_LT(made.sensors[0].unrest, 0.02);
  EXPECT_TRUE(score(made, "neutral face")->pass);
}

TEST(Normalisation, RangesAreMeasuredAndShrunkToTheUsualOne) {
  const Normalisation made = gathered().solve({});
  EXPECT_NEAR(made.sensors[0].moved, 1.6, 0.05);
  const double trust = 1200.0 / (1200 + 600);
  EXPECT_NEAR(std::log(made.sensors[0].range / kUsualRange),
              trust * std::log(made.sensors[0].moved / kUsualRange), 1e-9);
  EXPECT_LT(made.sensors[1].range, 0.5 * kUsualRange) << "a quiet sensor counts for more";
  EXPECT_GT(made.sensors[1].range, 0.05) << "but its noise is not blown up without end";
  EXPECT_TRUE(score(made, "range s0")->pass);
  EXPECT_FALSE(score(made, "range s1")->pass);
}

TEST(Normalisation, ANeutralAloneKeepsTheRanges) {
  const Normalisation before = gathered().solve({});
  NormalisationMaker maker(test::glasses_rig(2));
  maker.begin(StretchKind::neutral);
  for (int i = 0; i < 300; ++i) maker.add(StretchKind::neutral, lights(-2.4, -2.2));
  const Normalisation made = maker.solve(before);
  EXPECT_EQ(made.sensors[0].range, before.sensors[0].range);
  EXPECT_NEAR(made.sensors[0].neutral, -2.4, 1e-12);
  EXPECT_EQ(score(made, "range s0"), nullptr) << "it was not judged";
  EXPECT_EQ(maker.solve({}).sensors[0].range, kUsualRange);
}

TEST(Normalisation, SaysWhatIsWrongWithASensor) {
  NormalisationMaker maker(test::glasses_rig(2));
  maker.begin(StretchKind::neutral);
  for (int i = 0; i < 300; ++i) {
    GridLight light = lights(std::log(0.004), std::log(0.99));
    light.saturated[1] = 1;
    maker.add(StretchKind::neutral, light);
  }
  const Normalisation dim = maker.solve({});
  EXPECT_FALSE(score(dim, "light s0")->pass);
  EXPECT_NE(score(dim, "light s0")->sentence.find("hardly any light"), std::string::npos);
  EXPECT_FALSE(score(dim, "light s1")->pass);
  EXPECT_NE(score(dim, "light s1")->sentence.find("end of its range"), std::string::npos);

  maker.begin(StretchKind::neutral);
  for (int i = 0; i < 300; ++i) maker.add(StretchKind::neutral, lights(-2, -2, i < 200));
  const Normalisation gone = maker.solve({});
  EXPECT_TRUE(gone.complete) << "half of the sensors do";
  EXPECT_FALSE(gone.sensors[1].valid);
  EXPECT_FALSE(score(gone, "light s1")->pass);

  maker.begin(StretchKind::neutral);
  for (int i = 0; i < 300; ++i)
    maker.add(StretchKind::neutral, lights(-2 + std::sin(0.1 * i), -2 - std::sin(0.1 * i)));
  EXPECT_FALSE(score(maker.solve({}), "neutral face")->pass) << "it moved";

  maker.begin(StretchKind::neutral);
  EXPECT_FALSE(maker.solve({}).complete) << "nothing was seen";
}

TEST(Normalisation, FeaturesAreChangesFromNeutralInRanges) {
  const SensorNormalisation s{.sensor = "s", .valid = true, .neutral = -2, .range = 0.5};
  EXPECT_FLOAT_EQ(s.feature(-2), 0);
  EXPECT_FLOAT_EQ(s.feature(-1.75), 0.5F);
  EXPECT_FLOAT_EQ(s.feature(-3), -2);
  EXPECT_FLOAT_EQ(s.feature(9), static_cast<float>(SensorNormalisation::kLimit));
}

TEST(Normalisation, JsonTakesItBack) {
  const Normalisation made = gathered().solve({});
  const auto back = parse_normalisation(write_normalisation(made), "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, made);
}

TEST(Normalisation, RefusesWhatIsNone) {
  const std::string good = write_normalisation(gathered().solve({}));
  const auto code = [](const std::string& text) { return parse_normalisation(text, "test").error().code; };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  EXPECT_EQ(code(""), ErrorCode::malformed);
  EXPECT_EQ(code("[]"), ErrorCode::malformed);
  EXPECT_EQ(code("{}"), ErrorCode::malformed);
  EXPECT_EQ(code(with("\"complete\":true", "\"complete\":1")), ErrorCode::malformed);
  EXPECT_EQ(code(with("\"sensor\":\"s0\"", "\"sensor\":3")), ErrorCode::malformed);
  EXPECT_EQ(code(with("\"neutral\":", "\"neutral\":null,\"x\":")), ErrorCode::malformed);
  EXPECT_EQ(code(with("\"range\":", "\"range\":0,\"x\":")), ErrorCode::out_of_range);
  EXPECT_EQ(code(with("\"unrest\":", "\"unrest\":-1,\"x\":")), ErrorCode::out_of_range);
  EXPECT_EQ(code(with("\"pass\":", "\"pass\":\"yes\",\"x\":")), ErrorCode::malformed);
  std::string many = "{\"complete\":true,\"scores\":[],\"sensors\":[0";
  for (int i = 0; i < 300; ++i) many += ",0";
  EXPECT_EQ(code(many + "]}"), ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::eyewear::normalisation_test
