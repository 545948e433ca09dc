#include "mien/shaping/shaper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "mien/shaping/eyes.h"
#include "tests/allocation_count.h"
#include "tests/shaping/frames.h"

namespace mien::shaping::shaper_test {
namespace {

using face::Provenance;
using face::shape;

ShaperSettings everything() {
  ShaperSettings settings;
  settings.smoothing = 0.5;
  settings.smooth_head = true;
  settings.resting = true;
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    settings.limits.shapes[i] = {.gain = 1.5f, .low = i % 7 == 0 ? 0.1f : 0.0f, .high = 0.9f};
  return settings;
}

void expect_in_bounds(const face::OutputFrame& frame) {
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    ASSERT_GE(frame.weights[i], 0.0f);
    ASSERT_LE(frame.weights[i], 1.0f);
    ASSERT_GE(frame.confidence[i], 0.0f);
    ASSERT_LE(frame.confidence[i], 1.0f);
  }
  ASSERT_GE(frame.tongue_out, 0.0f);
  ASSERT_LE(frame.tongue_out, 1.0f);
  ASSERT_LE(frame.weights[shape("mouthClose")], frame.weights[shape("jawOpen")]);
  ASSERT_NEAR(frame.head.norm(), 1, 1e-6);
  ASSERT_TRUE(frame.eyes_rad[0].allFinite() && frame.eyes_rad[1].allFinite());
  ASSERT_LE(frame.eyes_rad[0].cwiseAbs().maxCoeff(), 1.6f);
}

TEST(Shaper, TheDefaultAddsNoDelayAndNoChange) {
  Shaper shaper;
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    face::OutputFrame in = moving(i, random);
    in.weights[shape("mouthClose")] = std::min(in.weights[shape("mouthClose")], in.weights[shape("jawOpen")]);
    face::OutputFrame out = in;
    shaper.apply(out, 12);
    ASSERT_EQ(in.weights, out.weights);
    ASSERT_EQ(in.head.coeffs(), out.head.coeffs());
    ASSERT_EQ(in.tongue_out, out.tongue_out);
    ASSERT_EQ(in.confidence, out.confidence);
    ASSERT_EQ(in.provenance, out.provenance);
    ASSERT_EQ(out.eyes_provenance, Provenance::predicted);
  }
}

TEST(Shaper, ObeysTheConstraintsOnlyWhenAskedTo) {
  ShaperSettings asked;
  asked.constraints = true;
  Shaper with(asked), without;
  Random random(7);
  bool moved = false;
  for (int i = 0; i < 300; ++i) {
    face::OutputFrame in = moving(i, random);
    in.weights[shape("mouthClose")] = std::min(in.weights[shape("mouthClose")], in.weights[shape("jawOpen")]);
    face::OutputFrame kept = in, bound = in;
    without.apply(kept, 12);
    with.apply(bound, 12);
    ASSERT_EQ(kept.weights, in.weights);
    // Steps of the projection are bounded after it.
    ASSERT_TRUE(i > 0 || face::natural_constraints().live().obeyed(bound.weights));
    moved = moved || !(bound.weights == in.weights);
  }
  EXPECT_TRUE(moved);
}

/// What the whole chain makes of some seconds in which all steps have work, or the chain without some.
std::vector<face::OutputFrame> shaped(const ChainSteps& off) {
  ShaperSettings settings = everything();
  settings.constraints = true;
  settings.off = off;
  Shaper shaper(settings);
  Random random(11);
  std::vector<face::OutputFrame> out;
  for (int i = 0; i < 900; ++i) {
    face::OutputFrame frame = moving(i, random);
    if (i == 300) shaper.recentre();
    if (i == 310) frame.weights[3] = std::numeric_limits<float>::quiet_NaN();
    if (i % 40 == 0) frame.weights[shape("jawOpen")] = 1;
    frame.eyes_rad.fill({0.3F, 0.1F});
    frame.eyes_provenance = Provenance::measured;
    frame.eyes_confidence = 1;
    for (const EyeShapes& eye : kEyeShapes)
      for (const std::size_t s : {eye.left, eye.right, eye.up, eye.down})
        frame.provenance[s] = Provenance::predicted;
    frame.provenance[shape("eyeBlink_L")] = Provenance::predicted;
    shaper.apply(frame, i > 600 && i < 700 ? 0 : 12);
    out.push_back(frame);
  }
  return out;
}

TEST(Shaper, WithEveryStepOffTheFrameIsTheTrackersToTheBit) {
  ShaperSettings settings = everything();
  settings.constraints = true;
  settings.off.set();
  Shaper shaper(settings);
  Random random(1);
  for (int i = 0; i < 1200; ++i) {
    face::OutputFrame in = moving(i, random);
    in.weights[5] = 1.5F;  // Out of range, as no tracker's is.
    in.weights[shape("mouthClose")] = 1;
    face::OutputFrame out = in;
    if (i == 300) shaper.recentre();
    shaper.apply(out, i > 400 && i < 500 ? 0 : 12);
    ASSERT_TRUE(same_bits(in, out)) << i;
  }
}

TEST(Shaper, EachStepCanBeLeftOutByItself) {
  const std::vector<face::OutputFrame> all = shaped({});
  for (std::size_t step = 0; step < kChainStepCount; ++step) {
    ChainSteps off;
    off.set(step);
    const std::vector<face::OutputFrame> without = shaped(off);
    const bool changes = !std::ranges::equal(all, without, same_bits);
    // Merging is CombinedTracker's.
    EXPECT_EQ(changes, step != static_cast<std::size_t>(ChainStep::merge)) << kChainStepNames[step];
  }
}

TEST(Shaper, AllocatesNothing) {
  ShaperSettings settings = everything();
  settings.constraints = true;
  Shaper shaper(settings);
  Random random(4);
  std::size_t allocated = 0;
  for (int i = 0; i < 1200; ++i) {
    face::OutputFrame frame = moving(i, random);
    if (i == 700) shaper.recentre();
    const std::size_t before = test::allocation_count();
    shaper.apply(frame, i > 900 && i < 1000 ? 0 : 12);
    allocated += test::allocation_count() - before;
  }
  EXPECT_EQ(allocated, 0U);
}

TEST(Shaper, WithoutRulesWeightsAreTheTrackersToTheBit) {
  ShaperSettings settings;
  settings.rules = face::RigConstraints();
  settings.constraints = true;
  Shaper shaper(settings);
  Random random(9);
  int above = 0;
  for (int i = 0; i < 1000; ++i) {
    const face::OutputFrame in = moving(i, random);
    above += in.weights[shape("mouthClose")] > in.weights[shape("jawOpen")] ? 1 : 0;
    face::OutputFrame out = in;
    shaper.apply(out, 12);
    ASSERT_EQ(std::memcmp(&in.weights, &out.weights, sizeof in.weights), 0) << i;
    ASSERT_EQ(in.tongue_out, out.tongue_out);
    ASSERT_EQ(in.head.coeffs(), out.head.coeffs());
  }
  EXPECT_GT(above, 100);
}

TEST(Shaper, ObeysRulesOfOnesOwnInPlaceOfItsOwn) {
  ShaperSettings settings;
  const std::string pair = "[[exclusive]]\na = \"jawLeft\"\nb = \"jawRight\"\n";
  settings.rules = face::RigConstraints::parse(
                       pair + "[[exclusive]]\na = \"mouthLeft\"\nb = \"mouthRight\"\nalways = true\n", "own")
                       .value();
  const auto shaped = [&settings] {
    Shaper shaper(settings);
    face::OutputFrame frame = measured(0, 0.4f);
    frame.weights[shape("jawLeft")] = frame.weights[shape("mouthRight")] = 0.3f;
    frame.weights[shape("jawOpen")] = 0;
    shaper.apply(frame, 12);
    return frame.weights;
  };
  // Those that always hold.
  EXPECT_EQ(shaped()[shape("jawLeft")], 0.3f);
  EXPECT_EQ(shaped()[shape("mouthRight")], 0);
  EXPECT_EQ(shaped()[shape("mouthClose")], 0.4f);
  settings.constraints = true;
  EXPECT_EQ(shaped()[shape("jawLeft")], 0);
  EXPECT_EQ(shaped()[shape("jawRight")], 0.4f);
  EXPECT_EQ(shaped()[shape("mouthRight")], 0);
  // They come after the smoothing, which would bring the pair back.
  settings.smoothing = 1;
  Shaper smooth(settings);
  Random random(10);
  for (int i = 0; i < 500; ++i) {
    face::OutputFrame frame = moving(i, random);
    for (float& w : frame.weights.values) w *= 0.5f;  // No step is bounded.
    smooth.apply(frame, 12);
    ASSERT_EQ(std::min(frame.weights[shape("jawLeft")], frame.weights[shape("jawRight")]), 0) << i;
  }
}

TEST(Shaper, WhatAlwaysHoldsHoldsWhileAStepIsBounded) {
  Shaper shaper;
  face::OutputFrame frame = measured(0, 0.2f);
  frame.weights[shape("jawOpen")] = 0.9f;
  shaper.apply(frame, 12);
  // The jaw shuts as far as it may in a frame, and the lips rise to there: bounded first, then ruled.
  frame = measured(1, 0.2f);
  frame.weights[shape("jawOpen")] = 0.1f;
  frame.weights[shape("mouthClose")] = 0.5f;
  shaper.apply(frame, 12);
  EXPECT_NEAR(frame.weights[shape("jawOpen")], 0.4f, 1e-5f);
  EXPECT_EQ(frame.weights[shape("mouthClose")], frame.weights[shape("jawOpen")]);
}

TEST(Shaper, KeepsItsPromisesWhateverComesIn) {
  Random random(2);
  const auto odd = [&random]() -> float {
    switch (random.below(8)) {
      case 0:
        return std::numeric_limits<float>::quiet_NaN();
      case 1:
        return std::numeric_limits<float>::infinity();
      case 2:
        return -std::numeric_limits<float>::infinity();
      case 3:
        return std::numeric_limits<float>::max();
      case 4:
        return -3;
      default:
        return static_cast<float>(random.uniform(-0.2, 1.2));
    }
  };
  for (int setting = 0; setting < 3; ++setting) {
    ShaperSettings settings = setting == 0 ? ShaperSettings{} : everything();
    if (setting == 2) {  // Even settings that no parser lets through.
      settings.smoothing = std::nan("");
      for (ShapeLimits& s : settings.limits.shapes) s = {.gain = odd(), .low = odd(), .high = odd()};
      settings.fallback = {.hold_s = -1, .neutral_s = 0, .return_s = std::nan("")};
    }
    Shaper shaper(settings);
    std::int64_t time = 0;
    for (int i = 0; i < 5000; ++i) {
      time += static_cast<std::int64_t>(random.below(4)) - (random.chance(0.01) ? 1000 : 0);
      face::OutputFrame frame = measured(time);
      for (float& w : frame.weights.values) w = odd();
      for (float& c : frame.confidence) c = odd();
      frame.head = Quat(odd(), odd(), odd(), odd());
      frame.tongue_out = odd();
      frame.head_confidence = odd();
      frame.eyes_rad = {Eigen::Vector2f(odd(), odd()), Eigen::Vector2f(odd(), odd())};
      frame.eyes_confidence = odd();
      frame.eyes_provenance = random.chance(0.5) ? Provenance::measured : Provenance::neutral;
      if (random.chance(0.005)) shaper.recentre();
      shaper.apply(frame, random.below(3));
      expect_in_bounds(frame);
    }
  }
}

TEST(Shaper, GivesTheSameBitsForTheSameCalls) {
  Shaper a(everything());
  Shaper b(everything());
  Random random_a(5);
  Random random_b(5);
  for (int i = 0; i < 1000; ++i) {
    face::OutputFrame x = moving(i, random_a);
    face::OutputFrame y = moving(i, random_b);
    const std::size_t sensors = i % 300 > 200 ? 0 : static_cast<std::size_t>(10 + i / 100 % 2);
    if (i == 320) {
      a.recentre();
      b.recentre();
    }
    a.apply(x, sensors);
    b.apply(y, sensors);
    ASSERT_TRUE(same_bits(x, y)) << i;
  }
}

TEST(Shaper, ACopyInMidStreamGoesOnAlike) {
  Shaper a(everything());
  Random random(6);
  for (int i = 0; i < 130; ++i) {
    face::OutputFrame frame = moving(i, random);
    if (i == 100) a.recentre();
    a.apply(frame, i < 90 || i > 95 ? 12 : 0);
  }
  Shaper b = a;
  for (int i = 130; i < 400; ++i) {
    face::OutputFrame x = moving(i, random);
    face::OutputFrame y = x;
    a.apply(x, 12);
    b.apply(y, 12);
    ASSERT_TRUE(same_bits(x, y));
  }
}

TEST(Shaper, LostSensorsEndInAQuietNeutralFace) {
  Shaper shaper;
  Random random(7);
  face::OutputFrame frame;
  for (int i = 0; i < 60; ++i) {
    frame = moving(i, random);
    shaper.apply(frame, 12);
  }
  for (int i = 60; i < 120; ++i) {
    face::OutputFrame next = moving(i, random);
    shaper.apply(next, 0);
    ASSERT_LE(largest_step(frame, next), 0.05) << i;
    if (i == 61) {
      EXPECT_EQ(next.provenance[0], Provenance::held);
      EXPECT_EQ(next.eyes_provenance, Provenance::held);
    }
    frame = next;
  }
  EXPECT_EQ(frame.weights, face::BlendshapeWeights{});
  EXPECT_EQ(frame.provenance[0], Provenance::neutral);
  EXPECT_EQ(frame.eyes_provenance, Provenance::neutral);
  EXPECT_EQ(frame.eyes_rad[0].norm(), 0);
  EXPECT_EQ(frame.confidence[0], 0);
  EXPECT_EQ(frame.tongue_out, 0);
}

TEST(Shaper, RecentresInOneActionAndTakesItBack) {
  Shaper shaper;
  int i = 0;
  const auto play = [&](int frames) {
    face::OutputFrame frame;
    for (const int end = i + frames; i < end; ++i) {
      frame = measured(i, 0.2f);
      frame.head = exp_rotation({0, -0.4, 0});
      shaper.apply(frame, 12);
    }
    return frame;
  };
  play(30);
  shaper.recentre();
  face::OutputFrame frame = play(95);
  EXPECT_EQ(frame.weights, face::BlendshapeWeights{});
  EXPECT_LT(angle_between(frame.head, Quat::Identity()), 1e-9);
  const Centre centre = shaper.recentring().centre();
  shaper.use_centre({});
  EXPECT_EQ(play(40).weights[0], 0.2f);
  shaper.use_centre(centre);
  EXPECT_EQ(play(40).weights, face::BlendshapeWeights{});
}

TEST(Shaper, ARestWhileSensorsAreLostIsNotTaken) {
  Shaper shaper;
  face::OutputFrame frame = measured(0, 0.3f);
  shaper.apply(frame, 12);
  shaper.recentre();
  for (int i = 1; i < 120; ++i) {
    frame = measured(i, 0.3f);
    shaper.apply(frame, 0);
  }
  EXPECT_EQ(shaper.recentring().state(), Recentre::State::failed);
  EXPECT_EQ(shaper.recentring().centre(), Centre{});
}

TEST(Shaper, BeginsAnewWhenTimeRunsBack) {
  Shaper shaper(everything());
  Centre centre;
  centre.rest[0] = 0.2f;
  shaper.use_centre(centre);
  Random random(8);
  face::OutputFrame frame;
  for (int i = 100; i < 200; ++i) {
    frame = moving(i, random);
    shaper.apply(frame, 12);
  }
  Shaper fresh(everything());
  fresh.use_centre(centre);
  fresh.reset();
  for (int i = 0; i < 50; ++i) {
    frame = moving(i, random);
    face::OutputFrame other = frame;
    shaper.apply(frame, 12);
    fresh.apply(other, 12);
    ASSERT_TRUE(same_bits(frame, other)) << i;
  }
}

/// A brow that rests at `rest`, and `raised` for the last frame.
float raised_brow(Shaper& shaper, std::int64_t& index, int frames, float rest, float raised) {
  face::OutputFrame frame;
  for (int i = 0; i <= frames; ++i) {
    frame = measured(index++, i < frames ? rest : raised);
    shaper.apply(frame, 12);
  }
  return frame.weights[shape("browInnerUp_L")];
}

TEST(Shaper, RestIsNeverTakenOffTwice) {
  // Rest in the middle of a bin, so that it is learnt without rounding; (0.5 - 1/7) / (6/7) = 5/12.
  const float rest = 9.0F / 63;
  ShaperSettings settings;
  settings.resting = true;
  std::int64_t index = 0;
  Shaper centred_first(settings);
  raised_brow(centred_first, index, 30, rest, rest);
  centred_first.recentre();
  EXPECT_NEAR(raised_brow(centred_first, index, 120, rest, 0.5F), 5.0F / 12, 1e-5);
  EXPECT_EQ(centred_first.resting().learnt(), RestingFace{});
  EXPECT_NEAR(raised_brow(centred_first, index, 900, rest, 0.5F), 5.0F / 12, 1e-5);
  EXPECT_NEAR(centred_first.resting().learnt().rest[shape("browInnerUp_L")], rest, 1e-6);

  Shaper learnt_first(settings);
  index = 0;
  raised_brow(learnt_first, index, 900, rest, rest);
  learnt_first.recentre();
  EXPECT_NEAR(raised_brow(learnt_first, index, 120, rest, 0.5F), 5.0F / 12, 1e-5);
  // A rest above the usual one is taken off whole: (0.5 - 0.3) / 0.7.
  learnt_first.recentre();
  EXPECT_NEAR(raised_brow(learnt_first, index, 120, 0.3F, 0.5F), 2.0F / 7, 1e-5);
  // Switched off, re-centring alone is left, and takes off the same.
  settings.resting = false;
  learnt_first.set(settings);
  EXPECT_NEAR(raised_brow(learnt_first, index, 60, 0.3F, 0.5F), 2.0F / 7, 1e-5);
}

TEST(Shaper, AHeldFaceTeachesNoRest) {
  ShaperSettings settings;
  settings.resting = true;
  settings.fallback.hold_s = 10;
  Shaper shaper(settings);
  for (int i = 0; i < 1300; ++i) {
    face::OutputFrame frame = measured(i, 0.25F);
    shaper.apply(frame, i < 590 ? 12 : 0);
  }
  EXPECT_EQ(shaper.resting().learnt(), RestingFace{});
}

TEST(Shaper, ARestingFaceOfEarlierIsPutInForce) {
  ShaperSettings settings;
  settings.resting = true;
  Shaper shaper(settings);
  std::int64_t index = 0;
  RestingFace earlier;
  earlier.rest[shape("browInnerUp_L")] = 0.2F;
  shaper.use_resting(earlier);
  EXPECT_FLOAT_EQ(raised_brow(shaper, index, 40, 0.2F, 0.6F), 0.5F);
  shaper.use_resting({});
  EXPECT_FLOAT_EQ(raised_brow(shaper, index, 40, 0.2F, 0.6F), 0.6F);
}

TEST(Shaper, MouthCloseRuleWinsOverLimits) {
  ShaperSettings settings;
  settings.limits.shapes[shape("mouthClose")] = {.gain = 4, .low = 0.5f};
  Shaper shaper(settings);
  face::OutputFrame frame = measured(0);
  shaper.apply(frame, 1);
  EXPECT_EQ(frame.weights[shape("mouthClose")], 0);
}

}  // namespace
}  // namespace mien::shaping::shaper_test
