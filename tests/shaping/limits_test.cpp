#include "mien/shaping/limits.h"

#include <gtest/gtest.h>

#include "tests/shaping/frames.h"

namespace mien::shaping::limits_test {
namespace {

TEST(Limits, TheDefaultChangesNoBit) {
  Random random(3);
  const face::OutputFrame in = moving(5, random);
  face::OutputFrame out = in;
  Limits{}.apply(out);
  EXPECT_TRUE(same_bits(in, out));
}

TEST(Limits, ScalesThenCuts) {
  Limits limits;
  limits.shapes[0] = {.gain = 2};
  limits.shapes[1] = {.gain = 0.5f};
  limits.shapes[2] = {.gain = 1, .low = 0.3f};
  limits.shapes[3] = {.gain = 4, .high = 0.8f};
  limits.shapes[4] = {.gain = 0};
  face::OutputFrame frame = measured(0, 0.25f);
  limits.apply(frame);
  EXPECT_EQ(frame.weights[0], 0.5f);
  EXPECT_EQ(frame.weights[1], 0.125f);
  EXPECT_EQ(frame.weights[2], 0.3f);
  EXPECT_EQ(frame.weights[3], 0.8f);
  EXPECT_EQ(frame.weights[4], 0.0f);
  EXPECT_EQ(frame.weights[5], 0.25f);
}

}  // namespace
}  // namespace mien::shaping::limits_test
