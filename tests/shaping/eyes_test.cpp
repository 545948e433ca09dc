#include "mien/shaping/eyes.h"

#include <gtest/gtest.h>

#include "tests/shaping/frames.h"

namespace mien::shaping::eyes_test {
namespace {

using face::Provenance;
using face::shape;

TEST(Eyes, LookWhereTheLidsFollow) {
  face::OutputFrame frame = measured(0);
  // To the performer's left: the left eye outwards, the right eye inwards.
  frame.weights[shape("eyeLookOut_L")] = 0.5f;
  frame.weights[shape("eyeLookIn_R")] = 0.4f;
  frame.weights[shape("eyeLookUp_L")] = 0.2f;
  frame.weights[shape("eyeLookDown_R")] = 1.0f;
  eyes_from_weights(frame);
  EXPECT_FLOAT_EQ(frame.eyes_rad[0].x(), 0.5f * 0.611f);
  EXPECT_FLOAT_EQ(frame.eyes_rad[0].y(), 0.2f * 0.611f);
  EXPECT_FLOAT_EQ(frame.eyes_rad[1].x(), 0.4f * 0.611f);
  EXPECT_FLOAT_EQ(frame.eyes_rad[1].y(), -0.611f);
  EXPECT_EQ(frame.eyes_provenance, Provenance::predicted);
  EXPECT_FLOAT_EQ(frame.eyes_confidence, 0.9f * 0.2f);

  frame = measured(1);
  frame.weights[shape("eyeLookIn_L")] = 1.0f;
  frame.weights[shape("eyeLookOut_R")] = 1.0f;
  eyes_from_weights(frame);
  EXPECT_FLOAT_EQ(frame.eyes_rad[0].x(), -0.611f);
  EXPECT_FLOAT_EQ(frame.eyes_rad[1].x(), -0.611f);
}

TEST(Eyes, ATrackersOwnAreKept) {
  face::OutputFrame frame = measured(0, 0.5f);
  frame.eyes_rad[0] = {0.1f, 0.2f};
  frame.eyes_provenance = Provenance::measured;
  frame.eyes_confidence = 0.9f;
  const face::OutputFrame before = frame;
  eyes_from_weights(frame);
  EXPECT_TRUE(same_bits(before, frame));
}

TEST(Eyes, AreNoSurerThanTheirShapes) {
  for (const Provenance p : {Provenance::held, Provenance::neutral, Provenance::audio}) {
    face::OutputFrame frame = measured(0);
    frame.provenance.fill(p);
    frame.confidence.fill(0.1f);
    eyes_from_weights(frame);
    EXPECT_EQ(frame.eyes_provenance, p);
    EXPECT_NEAR(frame.eyes_confidence, 0.02, 1e-6);
  }
}

}  // namespace
}  // namespace mien::shaping::eyes_test
