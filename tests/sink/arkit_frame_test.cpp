#include "mien/sink/arkit_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace mien::sink::arkit_frame_test {
namespace {

TEST(ArkitFrame, HoldsNothingThatMayNotBeSent) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), 1e30F, -1e30F}) {
    face::OutputFrame frame;
    frame.weights.values.fill(bad);
    frame.tongue_out = bad;
    frame.eyes_rad = {Eigen::Vector2f(bad, bad), Eigen::Vector2f(bad, bad)};
    const auto number = static_cast<double>(bad);
    frame.head.coeffs() << number, number, number, number;
    const ArkitFrame arkit = arkit_frame(frame);
    for (const float weight : arkit.weights.values) {
      EXPECT_GE(weight, 0);
      EXPECT_LE(weight, 1);
    }
    for (const auto& eye : arkit.eyes_rad) EXPECT_LE(eye.cwiseAbs().maxCoeff(), 1.5F);
    EXPECT_NEAR(arkit.head.norm(), 1, 1e-9);
  }
  face::OutputFrame nowhere;
  nowhere.head.coeffs().setZero();
  EXPECT_EQ(arkit_frame(nowhere).head.w(), 1);
}

TEST(ArkitFrame, KeepsTheMouthCloseBelowTheJaw) {
  face::OutputFrame frame;
  frame.weights[face::shape("jawOpen")] = 0.25F;
  frame.weights[face::shape("mouthClose")] = 0.75F;
  const ArkitFrame arkit = arkit_frame(frame);
  EXPECT_EQ(arkit.weights.values[face::arkit_index("jawOpen")], 0.25F);
  EXPECT_EQ(arkit.weights.values[face::arkit_index("mouthClose")], 0.25F);
}

TEST(ArkitFrame, SaysWhatIsTracked) {
  face::OutputFrame frame;
  frame.provenance.fill(face::Provenance::neutral);
  EXPECT_FALSE(arkit_frame(frame).face_tracked);
  EXPECT_FALSE(arkit_frame(frame).lids_tracked);
  frame.provenance[7] = face::Provenance::predicted;
  EXPECT_TRUE(arkit_frame(frame).face_tracked);
  using enum face::Provenance;
  for (const face::Provenance p : {measured, interpolated, predicted, held, audio, neutral}) {
    frame.eyes_provenance = p;
    frame.provenance[face::shape("eyeBlink_R")] = p;
    EXPECT_EQ(arkit_frame(frame).eyes_tracked, p == measured || p == interpolated);
    EXPECT_EQ(arkit_frame(frame).lids_tracked, p != audio && p != neutral);
  }
}

}  // namespace
}  // namespace mien::sink::arkit_frame_test
