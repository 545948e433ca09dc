#include "mien/shaping/recentre.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/shaping/frames.h"

namespace mien::shaping::recentre_test {
namespace {

using face::Provenance;
using face::shape;

/// A resting face that is not the tracker's zero.
face::OutputFrame resting(std::int64_t index) {
  face::OutputFrame frame = measured(index);
  frame.weights[shape("mouthFrown_L")] = 0.2f;
  frame.weights[shape("browDown_R")] = 0.1f;
  frame.head = exp_rotation({0, 0.5, 0}) * exp_rotation({0.1, 0, 0});
  return frame;
}

face::OutputFrame run(Recentre& recentre, face::OutputFrame frame) {
  recentre.apply(frame);
  return frame;
}

TEST(Recentre, ChangesNoBitUntilItIsAsked) {
  Recentre recentre;
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const face::OutputFrame in = moving(i, random);
    EXPECT_TRUE(same_bits(in, run(recentre, in)));
  }
  EXPECT_EQ(recentre.state(), Recentre::State::idle);
  EXPECT_EQ(recentre.centre(), Centre{});
}

TEST(Recentre, MakesThePresentFaceNeutralWithinTwoSeconds) {
  Recentre recentre;
  recentre.begin();
  face::OutputFrame before = resting(0);
  for (int i = 0; i < 120; ++i) {
    const face::OutputFrame out = run(recentre, resting(i));
    ASSERT_LE(largest_step(out, before), 0.2 * 0.06) << i;
    ASSERT_LE(angle_between(out.head, before.head), 0.5 * 0.06 + (i == 0 ? 1 : 0)) << i;
    before = out;
    if (i == 30) {
      EXPECT_EQ(recentre.state(), Recentre::State::measuring);
    }
    if (i == 70) {
      EXPECT_EQ(recentre.state(), Recentre::State::easing);
    }
  }
  EXPECT_EQ(recentre.state(), Recentre::State::done);
  EXPECT_EQ(recentre.performed(), 0u);
  const face::OutputFrame out = run(recentre, resting(120));
  for (const float w : out.weights.values) EXPECT_EQ(w, 0.0f);
  // Ahead is ahead; the nod stays.
  EXPECT_LT(angle_between(out.head, exp_rotation({0.1, 0, 0})), 1e-9);
  EXPECT_NEAR(recentre.centre().yaw_rad, 0.5, 1e-9);
  // The rest of the range is stretched: full stays full, half of the rest is half.
  face::OutputFrame full = resting(121);
  full.weights[shape("mouthFrown_L")] = 1;
  full.weights[shape("browDown_R")] = 0.55f;
  full = run(recentre, full);
  EXPECT_FLOAT_EQ(full.weights[shape("mouthFrown_L")], 1);
  EXPECT_FLOAT_EQ(full.weights[shape("browDown_R")], 0.5f);
}

TEST(Recentre, ABlinkOrAWordIsNotTheRest) {
  Recentre recentre;
  recentre.begin();
  for (int i = 0; i < 100; ++i) {
    face::OutputFrame frame = resting(i);
    if (i > 20 && i < 38) frame.weights[shape("eyeBlink_L")] = 1;
    if (i % 2 == 0) frame.weights[shape("jawOpen")] = 0.4f;
    run(recentre, frame);
  }
  EXPECT_EQ(recentre.centre().rest[shape("eyeBlink_L")], 0);
  EXPECT_EQ(recentre.centre().rest[shape("jawOpen")], 0);
  EXPECT_FLOAT_EQ(recentre.centre().rest[shape("mouthFrown_L")], 0.2f);
}

TEST(Recentre, AShapeThatIsPerformedKeepsItsRest) {
  Recentre recentre;
  Centre earlier;
  earlier.rest[shape("eyeBlink_L")] = 0.05f;
  recentre.use(earlier);
  recentre.begin();
  for (int i = 0; i < 100; ++i) {
    face::OutputFrame frame = resting(i);
    frame.weights[shape("eyeBlink_L")] = 0.9f;  // Eyes closed all through.
    run(recentre, frame);
  }
  EXPECT_EQ(recentre.centre().rest[shape("eyeBlink_L")], 0.05f);
  EXPECT_EQ(recentre.performed(), 1u);
}

TEST(Recentre, MeasuresOnlyFramesThatSensorsStandBehind) {
  Recentre recentre;
  recentre.begin();
  for (int i = 0; i < 120; ++i) {
    face::OutputFrame frame = resting(i);
    if (i % 3 != 0) frame.provenance.fill(i % 3 == 1 ? Provenance::held : Provenance::neutral);
    frame.head_provenance = frame.provenance[0];
    run(recentre, frame);
  }
  EXPECT_EQ(recentre.state(), Recentre::State::failed);
  EXPECT_EQ(recentre.centre(), Centre{});
  const face::OutputFrame in = resting(200);
  EXPECT_TRUE(same_bits(in, run(recentre, in)));
}

TEST(Recentre, AHeadAloneIsCentredWithoutAFace) {
  Recentre recentre;
  const Centre before{.rest = {0.1F}};
  recentre.use(before);
  recentre.begin();
  for (int i = 0; i < 120; ++i) {
    face::OutputFrame frame = resting(i);
    frame.provenance.fill(Provenance::neutral);
    frame.head_position_m = {1, 2, 3};
    frame.head_position_known = true;
    run(recentre, frame);
  }
  EXPECT_EQ(recentre.state(), Recentre::State::done);
  EXPECT_NEAR(recentre.centre().yaw_rad, 0.5, 1e-6);
  EXPECT_LT((recentre.centre().position_m - Vec3(1, 2, 3)).norm(), 1e-6);
  EXPECT_EQ(recentre.centre().rest, before.rest) << "no shape was seen";
}

TEST(Recentre, AnEaseGoesOnWhileTheNextRestIsMeasured) {
  Recentre recentre;
  Centre centre;
  centre.yaw_rad = 1;
  recentre.use(centre);
  run(recentre, measured(0));
  recentre.begin();
  for (int i = 1; i < 40; ++i) run(recentre, measured(i));
  EXPECT_NEAR(angle_between(run(recentre, measured(40)).head, exp_rotation({0, -1, 0})), 0, 1e-9);
}

TEST(Recentre, TurnsTheShortWayRound) {
  Recentre recentre;
  Centre centre;
  centre.yaw_rad = 3;
  recentre.use(centre);
  recentre.settle();
  centre.yaw_rad = -3;
  recentre.use(centre);
  face::OutputFrame before = run(recentre, measured(0));
  double turned = 0;
  for (int i = 1; i < 60; ++i) {
    const face::OutputFrame out = run(recentre, measured(i));
    turned += angle_between(out.head, before.head);
    before = out;
  }
  EXPECT_NEAR(turned, 2 * std::numbers::pi - 6, 1e-6);
}

TEST(Recentre, BringsACentreIntoRange) {
  Recentre recentre;
  Centre centre;
  centre.rest.fill(std::nanf(""));
  centre.rest[0] = 5;
  centre.rest[1] = -5;
  centre.yaw_rad = 7;
  recentre.use(centre);
  EXPECT_EQ(recentre.centre().rest[0], Centre::kRestAtMost);
  EXPECT_EQ(recentre.centre().rest[1], 0);
  EXPECT_EQ(recentre.centre().rest[2], 0);
  EXPECT_NEAR(recentre.centre().yaw_rad, 7 - 2 * std::numbers::pi, 1e-12);
}

TEST(Recentre, ThePresentPlaceIsZeroAndTurnsWithTheHeading) {
  Recentre recentre;
  recentre.begin();
  const auto standing = [](int i, const Vec3f& position_m) {
    face::OutputFrame frame = standing_at(i, position_m);
    frame.head = exp_rotation({0, std::numbers::pi / 2, 0});  // Looks along +X.
    return frame;
  };
  Vec3f before = {1, 1.5F, -0.25F};
  for (int i = 0; i < 120; ++i) {
    const Vec3f now = run(recentre, standing(i, {1, 1.5F, -0.25F})).head_position_m;
    ASSERT_LE((now - before).norm(), 1.9 * 0.06) << i;
    before = now;
  }
  EXPECT_EQ(recentre.state(), Recentre::State::done);
  EXPECT_LT((recentre.centre().position_m - Vec3(1, 1.5, -0.25)).norm(), 1e-6);
  EXPECT_LT(run(recentre, standing(120, {1, 1.5F, -0.25F})).head_position_m.norm(), 1e-6);
  // A step ahead, where the performer looks, is a step along +Z.
  const Vec3f ahead = run(recentre, standing(121, {1.5F, 1.5F, -0.25F})).head_position_m;
  EXPECT_LT((ahead - Vec3f(0, 0, 0.5F)).norm(), 1e-6);
  // Where nobody knows the place it stays 0.
  const face::OutputFrame unknown = run(recentre, measured(122));
  EXPECT_FALSE(unknown.head_position_known);
  EXPECT_EQ(unknown.head_position_m, Vec3f(0, 0, 0));
  // The next re-centring without a position keeps this one.
  recentre.begin();
  for (int i = 123; i < 240; ++i) run(recentre, measured(i));
  EXPECT_LT((recentre.centre().position_m - Vec3(1, 1.5, -0.25)).norm(), 1e-6);
}

}  // namespace
}  // namespace mien::shaping::recentre_test
