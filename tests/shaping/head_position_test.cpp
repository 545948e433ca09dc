#include "mien/shaping/head_position.h"

#include <gtest/gtest.h>

#include "mien/shaping/merge.h"
#include "mien/shaping/shaper.h"
#include "tests/shaping/frames.h"

namespace mien::shaping::head_position_test {
namespace {

using face::OutputFrame;
using face::Provenance;

constexpr double kReturn_s = 0.3;
/// The ease's largest step a frame, of the offset (ease_out.h).
constexpr double kLargestStep = 0.0975;

TEST(HeadPosition, PassesToTheBitWhileItStaysKnownOrUnknown) {
  for (const bool known : {false, true}) {
    HeadPosition position;
    for (int i = 0; i < 60; ++i) {
      OutputFrame frame = known ? standing_at(i, {0.1F * static_cast<float>(i % 7), 0, 1}) : measured(i);
      const OutputFrame in = frame;
      position.apply(frame, kReturn_s);
      ASSERT_TRUE(same_bits(frame, in));
    }
  }
}

TEST(HeadPosition, ComesAndGoesWithoutAJump) {
  HeadPosition position;
  Vec3f before = Vec3f::Zero();
  bool was_known = false;
  double most = 0;
  const auto run = [&](int i, OutputFrame frame) {
    position.apply(frame, kReturn_s);
    most = std::max<double>(most, (frame.head_position_m - before).norm());
    EXPECT_TRUE(frame.head_position_known || frame.head_position_m.isZero(0)) << i;
    if (was_known && !frame.head_position_known) {
      EXPECT_LT(before.norm(), 1e-4) << "no longer known when it is at 0";
    }
    before = frame.head_position_m;
    was_known = frame.head_position_known;
  };
  int i = 0;
  for (; i < 10; ++i) run(i, measured(i));
  for (; i < 90; ++i) run(i, standing_at(i, {0, 0, 1}));
  EXPECT_NEAR(before.z(), 1, 1e-4);
  for (; i < 100; ++i) run(i, measured(i));
  EXPECT_TRUE(was_known);
  for (; i < 105; ++i) run(i, standing_at(i, {0, 0, 1}));  // Back in the middle of it.
  for (; i < 200; ++i) run(i, measured(i));
  EXPECT_FALSE(was_known);
  EXPECT_LE(most, 1.2 * kLargestStep) << "of a metre, with the speed that it had";
  EXPECT_GT(most, 0.9 * kLargestStep);
}

/// Of IMUs, which know no position, and a program's weights.
TEST(HeadPosition, GoesWithTheHeadThroughMergeAndShaper) {
  Merge merge({"imu", "weights"});
  Shaper shaper;
  Vec3f before = Vec3f::Zero();
  double most = 0;
  OutputFrame out;
  const auto run = [&](int i, bool weights_there) {
    OutputFrame imu = measured(i), weights = face::neutral_frame(frame_time(i));
    if (weights_there) {
      weights.head = exp_rotation({0, 0.2, 0});
      weights.head_confidence = 0.5F;
      weights.head_provenance = Provenance::measured;
      weights.head_position_m = {0.5F, 0.1F, 0};
      weights.head_position_known = true;
    }
    const std::array<Merge::Source, 2> sources = {Merge::Source{&imu, 12},
                                                  Merge::Source{&weights, weights_there ? 1U : 0U}};
    shaper.apply(out, merge.apply(sources, out));
    most = std::max<double>(most, (out.head_position_m - before).norm());
    before = out.head_position_m;
  };
  int i = 0;
  for (; i < 60; ++i) run(i, true);
  EXPECT_EQ(merge.answers(kHeadPart), 1U);
  EXPECT_EQ(out.head_position_m, Vec3f(0.5F, 0.1F, 0));
  shaper.recentre();
  most = 0;
  for (; i < 180; ++i) run(i, true);
  EXPECT_LT(out.head_position_m.norm(), 1e-6);
  EXPECT_LT(most, 0.06);
  // The program is lost: the IMUs answer for the head, and where they do not know the place it is still 0.
  most = 0;
  for (; i < 300; ++i) run(i, false);
  EXPECT_EQ(merge.answers(kHeadPart), 0U);
  EXPECT_FALSE(out.head_position_known);
  EXPECT_LT(most, 1e-6);
  for (; i < 420; ++i) run(i, true);
  EXPECT_LT(most, 1e-6);
}

TEST(HeadPosition, StaysWhereItWasWhenAllIsLost) {
  Shaper shaper;
  OutputFrame out;
  for (int i = 0; i < 200; ++i) {
    out = i < 30 ? standing_at(i, {0.5F, 0, 0}) : face::neutral_frame(frame_time(i));
    shaper.apply(out, i < 30 ? 1 : 0);
  }
  EXPECT_EQ(out.head_provenance, Provenance::neutral);
  EXPECT_EQ(out.head_position_m, Vec3f(0.5F, 0, 0));
  EXPECT_TRUE(out.head_position_known);
}

}  // namespace
}  // namespace mien::shaping::head_position_test
