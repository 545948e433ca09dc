#include "mien/performer/performer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "mien/core/sha256.h"
#include "mien/performer/expression.h"
#include "mien/performer/expression_range.h"
#include "mien/performer/limits.h"

namespace mien::performer::performer_test {
namespace {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

constexpr Block kAllBlocks[] = {Block::reading, Block::expressions, Block::acted, Block::range_of_motion,
                                Block::free,    Block::eating,      Block::rapid, Block::mixed};

std::string hash_of(const face::Motion& motion) {
  Sha256 hash;
  for (const auto& frame : motion.frames) {
    hash.add(std::as_bytes(std::span(frame.weights.values)));
    hash.add_value(frame.time_s);
    hash.add_value(frame.tongue_out);
    hash.add(std::as_bytes(std::span(frame.head.coeffs().data(), 4)));
    hash.add(std::as_bytes(std::span(frame.head_position_m.data(), 3)));
  }
  return hash.hex();
}

face::Motion play(Block block, double seconds, std::uint64_t seed) {
  Random random(seed);
  const Style style = draw_style(random);
  return perform(default_script(block, seconds), style, random.fork("play"));
}

class EveryBlock : public testing::TestWithParam<Block> {};
INSTANTIATE_TEST_SUITE_P(Performer, EveryBlock, testing::ValuesIn(kAllBlocks),
                         [](const auto& block) { return std::string(block_name(block.param)); });

TEST_P(EveryBlock, SameSeedSameBitsAndAnotherSeedOthers) {
  EXPECT_EQ(hash_of(play(GetParam(), 30, 5)), hash_of(play(GetParam(), 30, 5)));
  EXPECT_NE(hash_of(play(GetParam(), 30, 5)), hash_of(play(GetParam(), 30, 6)));
}

TEST_P(EveryBlock, StandsOnTheFrameGrid) {
  const auto motion = play(GetParam(), 12.5, 1);
  ASSERT_EQ(motion.frames.size(), 750U);
  for (std::size_t i = 0; i < motion.frames.size(); ++i)
    EXPECT_EQ(motion.frames[i].time_s, to_seconds(frame_offset(static_cast<std::int64_t>(i))));
  EXPECT_TRUE(motion.has_head);
}

TEST_P(EveryBlock, StaysInRangeAndMouthCloseBelowJawOpen) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    for (const auto& frame : play(GetParam(), 40, seed).frames) {
      for (std::size_t k = 0; k < kShapeCount; ++k) {
        ASSERT_GE(frame.weights[k], 0.0F) << kShapeNames[k];
        ASSERT_LE(frame.weights[k], kLargestWeight) << kShapeNames[k];
      }
      ASSERT_LE(frame.weights[shape("mouthClose")], frame.weights[shape("jawOpen")]);
      ASSERT_GE(frame.tongue_out, 0.0F);
      ASSERT_LE(frame.tongue_out, 1.0F);
      ASSERT_NEAR(frame.head.norm(), 1.0, 1e-9);
      ASSERT_TRUE(frame.has_face);
    }
  }
}

TEST_P(EveryBlock, NeverJumps) {
  // A blink closes in five frames, at most 0.39 a frame; nothing on a face is much faster.
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const auto motion = play(GetParam(), 60, seed);
    for (std::size_t i = 1; i < motion.frames.size(); ++i) {
      const auto& before = motion.frames[i - 1];
      const auto& now = motion.frames[i];
      for (std::size_t k = 0; k < kShapeCount; ++k) {
        const float bound = kShapeNames[k].starts_with("eyeLook") ? 0.75F : 0.6F;
        ASSERT_LT(std::abs(now.weights[k] - before.weights[k]), bound)
            << kShapeNames[k] << " at " << now.time_s << " s, seed " << seed;
      }
      // 200 degrees a second; of a head that darts, 460.
      ASSERT_LT(angle_between(before.head, now.head), GetParam() == Block::rapid ? 0.135 : 0.06)
          << now.time_s << " s, seed " << seed;
      ASSERT_LT((now.head_position_m - before.head_position_m).norm(), 0.09) << now.time_s;
    }
  }
}

TEST_P(EveryBlock, MovesTheFace) {
  const auto motion = play(GetParam(), 40, 3);
  double travel = 0;
  for (std::size_t i = 1; i < motion.frames.size(); ++i)
    for (std::size_t k = 0; k < kShapeCount; ++k)
      travel += std::abs(motion.frames[i].weights[k] - motion.frames[i - 1].weights[k]);
  EXPECT_GT(travel / motion.duration_s(), 2.0);  // Weight a second, over all shapes.
}

TEST(Performer, ScriptsWithoutHeadLeaveItUpright) {
  Script script = default_script(Block::free, 5);
  script.moves_head = false;
  const auto motion = perform(script, plain_style(), Random(1));
  EXPECT_FALSE(motion.has_head);
  for (const auto& frame : motion.frames) {
    EXPECT_EQ(frame.head.coeffs(), Quat::Identity().coeffs());
    EXPECT_EQ(frame.head_position_m, Vec3::Zero());
  }
}

TEST(Performer, EmptyScriptGivesOneFrame) {
  EXPECT_EQ(perform(Script{}, plain_style(), Random(1)).frames.size(), 1U);
}

TEST(Performer, FreeMotionReachesEveryShapeAndBeyondOne) {
  face::BlendshapeWeights largest;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (const auto& frame : play(Block::free, 60, seed).frames)
      for (std::size_t k = 0; k < kShapeCount; ++k) largest[k] = std::max(largest[k], frame.weights[k]);
  std::size_t beyond = 0;
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    EXPECT_GT(largest[k], kShapeNames[k].starts_with("eyeLook") || k == shape("mouthClose") ? 0.3F : 0.7F)
        << kShapeNames[k];
    beyond += largest[k] > 1.0F ? 1 : 0;
  }
  EXPECT_GT(beyond, 10U);
}

TEST(Performer, FreeMotionIsSparse) {
  // Most shapes rest most of the time: the median over all is far below the mean of the busy ones.
  std::vector<float> all;
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    for (const auto& frame : play(Block::free, 30, seed).frames)
      all.insert(all.end(), frame.weights.values.begin(), frame.weights.values.end());
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2));
  EXPECT_LT(all[all.size() / 2], 0.12F);
}

TEST(Performer, RangeOfMotionTakesEveryGroupThroughItsRange) {
  face::BlendshapeWeights largest;
  const auto motion = perform(default_script(Block::range_of_motion, 400), plain_style(), Random(2));
  for (const auto& frame : motion.frames)
    for (std::size_t k = 0; k < kShapeCount; ++k) largest[k] = std::max(largest[k], frame.weights[k]);
  for (std::size_t k = 0; k < kShapeCount; ++k) EXPECT_GT(largest[k], 0.5F) << kShapeNames[k];
  EXPECT_TRUE(std::ranges::any_of(motion.frames, [](const auto& frame) { return frame.tongue_out > 0.9F; }));
}

TEST(Performer, OppositesExcludeEachOther) {
  for (const auto& frame : play(Block::free, 120, 4).frames) {
    EXPECT_LT(std::min(frame.weights[shape("jawLeft")], frame.weights[shape("jawRight")]), 0.06F);
    EXPECT_LT(std::min(frame.weights[shape("mouthLeft")], frame.weights[shape("mouthRight")]), 0.06F);
    EXPECT_EQ(std::min(frame.weights[shape("eyeLookUp_L")], frame.weights[shape("eyeLookDown_L")]), 0.0F);
    EXPECT_EQ(std::min(frame.weights[shape("eyeLookIn_R")], frame.weights[shape("eyeLookOut_R")]), 0.0F);
  }
}

TEST(Limits, LipClosureMakesMouthCloseEqualJawOpen) {
  face::BlendshapeWeights weights;
  weights[shape("jawOpen")] = 0.8F;
  weights[shape("mouthLowerDown_L")] = 0.5F;
  apply_limits(weights, 1);
  EXPECT_FLOAT_EQ(weights[shape("mouthClose")], weights[shape("jawOpen")]);
  EXPECT_LT(weights[shape("mouthLowerDown_L")], 0.06F);
}

TEST(Limits, CeilingIsTheIdentityBelowAndSmoothAbove) {
  EXPECT_EQ(soft_ceiling(0.5F), 0.5F);
  EXPECT_EQ(soft_ceiling(-0.5F), 0.0F);
  EXPECT_NEAR(soft_ceiling(0.901F), 0.901F, 1e-4);
  EXPECT_LE(soft_ceiling(50.0F), kLargestWeight);
}

TEST(Style, IsDrawnFromItsSeedAlone) {
  Random a(7);
  Random b(7);
  Random c(8);
  const Style first = draw_style(a);
  EXPECT_EQ(first, draw_style(b));
  EXPECT_NE(first, draw_style(c));
  EXPECT_NE(first, draw_style(a));  // The stream has moved on.
}

TEST(Style, RestsStayModestAndVaryBetweenPeople) {
  Random random(11);
  double lowest = 1;
  double highest = 0;
  for (int person = 0; person < 200; ++person) {
    const Style style = draw_style(random);
    for (const float rest : style.rest.values) {
      ASSERT_GE(rest, 0.0F);
      ASSERT_LT(rest, 0.7F);
    }
    lowest = std::min<double>(lowest, style.rest[shape("eyeWide_L")]);
    highest = std::max<double>(highest, style.rest[shape("eyeWide_L")]);
    ASSERT_GE(style.blink_rate_per_min, 10.0F);
    ASSERT_LE(style.blink_rate_per_min, 25.0F);
  }
  EXPECT_LT(lowest, 0.02);
  EXPECT_GT(highest, 0.25);
}

TEST(Expressions, NamesAreUniqueAndPosesInRange) {
  const auto library = expression_library();
  for (std::size_t i = 0; i < library.size(); ++i) {
    EXPECT_FALSE(library[i].pose.empty()) << library[i].name;
    for (const PosePart& part : library[i].pose) {
      EXPECT_GT(part.weight, 0.0F);
      EXPECT_LE(part.weight, 1.0F);
    }
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(library[i].name, library[j].name);
  }
}

TEST(Expressions, OnePersonShowsOneExpressionTheSameWay) {
  Random random(3);
  const Style one = draw_style(random);
  const Style other = draw_style(random);
  const Expression& joy = emotion_expression(Emotion::joy);
  const auto weights = [&](const Style& style) {
    std::vector<float> all;
    for (const PosePart& part : personal_variant(joy, style)) all.push_back(part.weight);
    return all;
  };
  EXPECT_EQ(weights(one), weights(one));
  EXPECT_NE(weights(one), weights(other));
}

TEST(Expressions, EachEmotionIsToldFromTheOthersWhenActed) {
  // The mean face of an acted line lies nearer to its own emotion's pose than to any other's.
  const auto mean_of = [](Emotion emotion) {
    Script script;
    Segment segment;
    segment.block = Block::acted;
    segment.emotion = emotion;
    segment.intensity = 0.9;
    segment.duration_s = 30;
    script.segments.push_back(segment);
    std::array<double, kShapeCount> mean{};
    const auto motion = perform(script, plain_style(), Random(1));
    for (const auto& frame : motion.frames)
      for (std::size_t k = 0; k < kShapeCount; ++k)
        mean[k] += frame.weights[k] / static_cast<double>(motion.frames.size());
    return mean;
  };
  const auto neutral = mean_of(Emotion::neutral);
  for (std::size_t e = 1; e < kEmotionCount; ++e) {
    const auto mean = mean_of(static_cast<Emotion>(e));
    std::size_t best = 0;
    double best_cosine = -1;
    for (std::size_t other = 1; other < kEmotionCount; ++other) {
      double dot = 0;
      double pose_sum = 0;
      double mean_sum = 0;
      for (const PosePart& part : emotion_expression(static_cast<Emotion>(other)).pose) {
        dot += part.weight * (mean[part.shape] - neutral[part.shape]);
        pose_sum += part.weight * part.weight;
      }
      for (std::size_t k = 0; k < kShapeCount; ++k)
        mean_sum += (mean[k] - neutral[k]) * (mean[k] - neutral[k]);
      const double cosine = dot / std::sqrt(pose_sum * mean_sum);
      if (cosine > best_cosine) {
        best_cosine = cosine;
        best = other;
      }
    }
    EXPECT_EQ(best, e) << "the emotion of this number looks like another";
  }
}

TEST(Scripts, DefaultScriptsLastAsLongAsAsked) {
  for (const Block block : kAllBlocks)
    for (const double seconds : {0.5, 7.0, 90.0})
      EXPECT_NEAR(default_script(block, seconds).duration_s(), seconds, 1e-9);
  Random random(1);
  EXPECT_NEAR(random_script(333, random).duration_s(), 333, 1e-9);
}

TEST(Scripts, NamesComeBack) {
  for (const Block block : kAllBlocks) EXPECT_EQ(parse_block(block_name(block)).value(), block);
  const auto wrong = parse_block("dance");
  ASSERT_FALSE(wrong.has_value());
  EXPECT_EQ(wrong.error().code, ErrorCode::not_found);
  EXPECT_NE(wrong.error().message().find("range_of_motion"), std::string::npos);
}

}  // namespace
}  // namespace mien::performer::performer_test
