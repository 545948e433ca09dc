#include "mien/shaping/resting.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "tests/allocation_count.h"
#include "tests/shaping/frames.h"

namespace mien::shaping::resting_test {
namespace {

using face::Provenance;
using face::shape;

constexpr std::size_t kBrow = shape("browInnerUp_L");
constexpr std::size_t kLid = shape("eyeBlink_L");

/// The middle of a bin of the histogram: what is learnt of it is exact.
constexpr float of_bin(int bin) {
  return static_cast<float>(bin) / 63;
}

/// Plays frames on, one after the other.
struct Player {
  Resting resting;
  std::int64_t index = 0;
  face::OutputFrame frame;  // The last output.

  explicit Player(bool on = true) { resting.set(on); }
  /// `frames` of a measured face with all weights `weight`, lids apart.
  void play(int frames, float weight, float lids = 0) {
    for (int i = 0; i < frames; ++i) {
      frame = measured(index++, weight);
      frame.weights[kLid] = frame.weights[shape("eyeBlink_R")] = lids;
      resting.apply(frame);
    }
  }
  /// What comes out for one more such frame.
  float brow(float weight) {
    play(1, weight);
    return frame.weights[kBrow];
  }
};

TEST(Resting, TakesTheUsualValueOffAfterTwelveSeconds) {
  Player player;
  const float rest = of_bin(16);
  player.play(599, rest);
  EXPECT_EQ(player.frame.weights[kBrow], rest);
  EXPECT_EQ(player.resting.learnt(), RestingFace{});
  player.play(121, rest);  // Eases from the 600th frame on.
  EXPECT_FLOAT_EQ(player.resting.learnt().rest[kBrow], rest);
  EXPECT_EQ(player.frame.weights[kBrow], 0);
  EXPECT_FLOAT_EQ(player.brow(0.6F), (0.6F - rest) / (1 - rest));
  EXPECT_EQ(player.brow(1), 1);
  EXPECT_EQ(player.frame.weights[shape("jawOpen")], 1);
  player.play(1, 0.3F);
  EXPECT_EQ(player.frame.weights[shape("jawOpen")], 0.3F);
  EXPECT_EQ(player.frame.weights[shape("mouthFunnel")], 0.3F);
}

TEST(Resting, EasesInOverTwoSeconds) {
  Player player;
  player.play(600, 0.25F);
  const float learnt = player.resting.learnt().rest[kBrow];
  EXPECT_EQ(player.resting.present().rest[kBrow], 0);
  player.play(60, 0.25F);  // Half way: smoothstep(1/2) = 1/2.
  EXPECT_NEAR(player.resting.present().rest[kBrow], 0.5F * learnt, 1e-6);
  player.play(30, 0.25F);  // 3/4: 27/32.
  EXPECT_NEAR(player.resting.present().rest[kBrow], 27.0F / 32 * learnt, 1e-6);
  player.play(30, 0.25F);
  EXPECT_EQ(player.resting.present().rest[kBrow], learnt);
}

TEST(Resting, AFaceThatRestsAtZeroKeepsItsBits) {
  Player player;
  Random random(1);
  for (int i = 0; i < 3000; ++i) {
    face::OutputFrame in = measured(i, 0);
    if (i % 3 == 0) in = moving(i, random);
    in.weights[kLid] = in.weights[shape("eyeBlink_R")] = i % 3 == 0 ? 1.0F : 0.0F;
    face::OutputFrame out = in;
    player.resting.apply(out);
    ASSERT_TRUE(same_bits(in, out)) << i;
  }
}

TEST(Resting, LidsCloseAtTheLargestOfTheirBlinks) {
  Player player;
  const float open = of_bin(19);
  const std::array peaks = {of_bin(50), of_bin(40), of_bin(45)};
  for (int i = 0; i < 120; ++i) {  // A blink a second, for two minutes.
    player.play(54, 0, open);
    player.play(6, 0, peaks.at(static_cast<std::size_t>(i) % 3));
  }
  EXPECT_NEAR(player.resting.learnt().rest[kLid], open, 1e-6);
  EXPECT_NEAR(player.resting.learnt().full[kLid], peaks[0], 1e-6);
  player.play(1, 0, 0.55F);
  EXPECT_NEAR(player.frame.weights[kLid], (0.55F - open) / (peaks[0] - open), 1e-6);
  player.play(1, 0, 0.9F);
  EXPECT_EQ(player.frame.weights[kLid], 1);
  player.play(1, 0, 0.1F);
  EXPECT_EQ(player.frame.weights[kLid], 0);
}

TEST(Resting, LidsThatRestNearZeroAreBelievedToCloseAtOne) {
  const auto full_of = [](float open, float closed) {
    Player player;
    for (int i = 0; i < 120; ++i) {
      player.play(54, 0, open);
      player.play(6, 0, closed);
    }
    return player.resting.learnt().full[kLid];
  };
  EXPECT_EQ(full_of(0, 0.7F), 1);
  // In proportion up to a rest of 0.1: 1 - (0.05 / 0.1) (1 - 0.7) = 0.85 for a rest of 0.05.
  EXPECT_NEAR(full_of(of_bin(3), 0.7F), 1 - of_bin(3) / 0.1F * 0.3F, 1e-6);
  EXPECT_NEAR(full_of(of_bin(7), 0.7F), 0.7F, 1e-6);
}

TEST(Resting, LidsWithoutBlinksKeepTheirFull) {
  Player player;
  player.play(60 * 60, 0, of_bin(19));
  EXPECT_EQ(player.resting.learnt().full[kLid], 1);
  RestingFace earlier;
  earlier.rest[kLid] = of_bin(19);
  earlier.full[kLid] = 0.8F;
  player.resting.use(earlier);
  player.play(60 * 60, 0, of_bin(19));
  EXPECT_EQ(player.resting.learnt().full[kLid], 0.8F);
}

TEST(Resting, LidsThatHardlyMoveAreNotExaggeratedMoreThanFourfold) {
  Player player;
  const float open = of_bin(19);
  for (int i = 0; i < 120; ++i) {
    player.play(54, 0, open);
    player.play(6, 0, open + 0.2F);
  }
  EXPECT_FLOAT_EQ(player.resting.learnt().full[kLid], open + 0.25F);
  player.play(1, 0, open + 0.125F);
  EXPECT_NEAR(player.frame.weights[kLid], 0.5F, 1e-5);
}

TEST(Resting, WhatIsOftenLowerIsNoRest) {
  // A smile of 0.4 that is held for 25 of the 30 s is the mode, but not the face at rest.
  Player player;
  player.play(300, 0);
  player.play(1500, 0.4F);
  EXPECT_EQ(player.resting.learnt().rest[kBrow], 0);
  EXPECT_EQ(player.frame.weights[kBrow], 0.4F);
  // 36 of 1,800 are a fiftieth. With fewer below it is rest.
  player.play(200, 0.4F);
  EXPECT_EQ(player.resting.learnt().rest[kBrow], 0);
  player.play(160, 0.4F);
  EXPECT_GT(player.resting.learnt().rest[kBrow], 0.01F);
}

TEST(Resting, BlinksDoNotHideThatEyesRestWide) {
  Player player;
  for (int i = 0; i < 30; ++i) {  // Closed a twentieth of the time, which brings eyeWide to 0.
    player.play(57, of_bin(20));
    player.play(3, 0, 1);
  }
  EXPECT_NEAR(player.resting.learnt().rest[shape("eyeWide_L")], of_bin(20), 1e-6);
  EXPECT_EQ(player.resting.learnt().rest[kBrow], 0);
}

TEST(Resting, WhatIsUsuallyAboveAHalfIsPerformed) {
  Player player;
  player.play(1800, of_bin(31));  // 0.492.
  EXPECT_FLOAT_EQ(player.resting.learnt().rest[kBrow], of_bin(31));
  Player other;
  other.play(1800, of_bin(32));  // 0.508.
  EXPECT_EQ(other.resting.learnt().rest[kBrow], 0);
  EXPECT_EQ(other.frame.weights[kBrow], of_bin(32));
  // Neither does it change what was learnt before.
  player.play(3000, of_bin(40));
  EXPECT_FLOAT_EQ(player.resting.learnt().rest[kBrow], of_bin(31));
}

TEST(Resting, LearnsNothingThatIsUnsureOrNotMeasured) {
  const auto learnt_from = [](float confidence, Provenance provenance) {
    Player player;
    for (int i = 0; i < 1200; ++i) {
      face::OutputFrame frame = measured(i, 0.25F);
      frame.confidence.fill(confidence);
      frame.provenance.fill(provenance);
      player.resting.apply(frame);
    }
    return player.resting.learnt().rest[kBrow];
  };
  EXPECT_GT(learnt_from(0.5F, Provenance::measured), 0.2F);
  EXPECT_EQ(learnt_from(0.49F, Provenance::measured), 0);
  EXPECT_EQ(learnt_from(std::nanf(""), Provenance::measured), 0);
  for (const Provenance other : {Provenance::interpolated, Provenance::predicted, Provenance::held,
                                 Provenance::audio, Provenance::neutral})
    EXPECT_EQ(learnt_from(0.9F, other), 0);
}

TEST(Resting, StaysWhileNothingIsTrusted) {
  Player player;
  player.play(1800, of_bin(16));
  const RestingFace before = player.resting.learnt();
  for (int i = 0; i < 3600; ++i) {
    face::OutputFrame frame = measured(player.index++, 0);
    frame.confidence.fill(0.1F);
    player.resting.apply(frame);
  }
  EXPECT_EQ(player.resting.learnt(), before);
  EXPECT_EQ(player.brow(of_bin(16)), 0);  // In force all the same.
}

TEST(Resting, ChangesByAFiftiethASecond) {
  Player player;
  const float rest = of_bin(16);
  player.play(1800, rest);
  player.play(60, 0);  // More than the lowest fiftieth.
  const float first = player.resting.learnt().rest[kBrow];
  EXPECT_LT(first, rest);
  RestingFace last = player.resting.learnt();
  for (int i = 0; i < 300; ++i) {
    player.play(1, 0, 0.4F);
    const RestingFace& now = player.resting.learnt();
    ASSERT_NEAR(last.rest[kBrow] - now.rest[kBrow], 0.02F / 60, 1e-7);
    ASSERT_LE(std::abs(now.rest[kLid] - last.rest[kLid]), 0.02F / 60 + 1e-7);
    ASSERT_LE(std::abs(now.full[kLid] - last.full[kLid]), 0.02F / 60 + 1e-7);
    last = now;
  }
  EXPECT_NEAR(player.resting.learnt().rest[kBrow], first - 0.1F, 1e-5);
  player.play(600, 0);
  EXPECT_EQ(player.resting.learnt().rest[kBrow], 0);
}

TEST(Resting, OffLeavesEveryBitAndCanBeSwitchedInMidStream) {
  Player player(false);
  Random random(2);
  for (int i = 0; i < 1500; ++i) {
    const face::OutputFrame in = moving(i, random);
    face::OutputFrame out = in;
    player.resting.apply(out);
    ASSERT_TRUE(same_bits(in, out));
  }
  EXPECT_EQ(player.resting.learnt(), RestingFace{});
  player.index = 1500;
  player.resting.set(true);
  player.play(800, 0.25F);
  EXPECT_LT(player.frame.weights[kBrow], 0.01F);
  player.resting.set(false);
  player.play(16, 0.25F);                                  // Half of the half second.
  EXPECT_NEAR(player.frame.weights[kBrow], 0.143F, 0.01);  // (0.25 - 0.127) / (1 - 0.127)
  player.play(16, 0.25F);
  EXPECT_EQ(player.frame.weights[kBrow], 0.25F);
  EXPECT_GT(player.resting.learnt().rest[kBrow], 0.2F);
  player.resting.set(true);
  player.play(32, 0.25F);
  EXPECT_LT(player.frame.weights[kBrow], 0.01F);
}

TEST(Resting, AnEarlierFaceIsEasedInAndLearntOnFrom) {
  Player player;
  player.play(1800, of_bin(16));
  RestingFace earlier;
  earlier.rest[kBrow] = 0.1F;
  player.resting.use(earlier);
  EXPECT_EQ(player.resting.learnt(), earlier);
  float last = player.resting.present().rest[kBrow];
  for (int i = 0; i < 31; ++i) {
    player.play(1, of_bin(16));
    EXPECT_LE(last - player.resting.present().rest[kBrow], 0.008F);
    last = player.resting.present().rest[kBrow];
  }
  EXPECT_EQ(last, 0.1F);
  player.play(568, of_bin(16));
  EXPECT_EQ(player.resting.learnt(), earlier);  // It learns anew, ten seconds long.
  player.play(60, of_bin(16));
  EXPECT_NEAR(player.resting.learnt().rest[kBrow], 0.12F, 0.001);
  // What an earlier face knew nothing of is eased in as at first.
  EXPECT_FLOAT_EQ(player.resting.learnt().rest[shape("noseSneer_L")], of_bin(16));
}

TEST(Resting, ResetKeepsWhatIsInForceAndForgetsTheRest) {
  Player player;
  player.play(1800, of_bin(16));
  const RestingFace learnt = player.resting.learnt();
  player.resting.reset();
  EXPECT_EQ(player.resting.learnt(), learnt);
  player.index = 0;
  player.play(599, 0);
  EXPECT_EQ(player.resting.learnt(), learnt);
  EXPECT_EQ(player.resting.present(), learnt);
  player.play(60, 0);
  EXPECT_LT(player.resting.learnt().rest[kBrow], learnt.rest[kBrow]);
}

TEST(Resting, OddWeightsTeachNothingOrTheirBound) {
  Player player;
  for (int i = 0; i < 1200; ++i) {
    face::OutputFrame frame = measured(i, i % 2 == 0 ? 0.25F : std::numeric_limits<float>::quiet_NaN());
    player.resting.apply(frame);
  }
  player.index = 1200;
  EXPECT_EQ(player.resting.learnt().rest[kBrow], of_bin(16));
  player.play(1800, 1e30F, 1e30F);
  EXPECT_EQ(player.resting.learnt().rest[kBrow], of_bin(16));
  EXPECT_EQ(player.frame.weights[kBrow], 1);
  for (const float full : player.resting.learnt().full) EXPECT_LE(full, 1);
}

TEST(Resting, AllocatesNothing) {
  const std::size_t before = test::allocation_count();
  Player player;
  player.play(2000, 0.25F, 0.3F);
  player.resting.use({});
  player.play(700, 0.1F, 0.3F);
  player.resting.set(false);
  player.play(100, 0.1F, 0.3F);
  EXPECT_EQ(test::allocation_count(), before);
}

}  // namespace
}  // namespace mien::shaping::resting_test
