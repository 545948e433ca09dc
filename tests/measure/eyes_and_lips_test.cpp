#include "mien/measure/eyes_and_lips.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/units.h"

namespace mien::measure::eyes_and_lips_test {
namespace {

using face::shape;
using Track = std::vector<face::BlendshapeWeights>;

/// Lids 10 mm apart, which eyeBlink closes; lips that touch, which jawOpen opens by 20 mm.
face::Face lidded_face() {
  face::Face face;
  face.neutral_m.assign(68, Vec3f::Zero());
  for (std::uint32_t i = 0; i < 68; ++i) face.landmarks[i] = i;
  face.has_landmarks = true;
  for (const std::string_view name : face::kShapeNames) face.shapes.push_back({std::string(name), {}, {}});
  for (const std::uint32_t upper : {37U, 38U, 43U, 44U}) {
    face.neutral_m[upper].y() = 0.010F;
    face::Shape& blink = face.shapes[upper < 40 ? shape("eyeBlink_R") : shape("eyeBlink_L")];
    blink.vertex.push_back(upper);
    blink.delta_m.emplace_back(0, -0.010F, 0);
  }
  face.shapes[shape("jawOpen")].vertex = {66};
  face.shapes[shape("jawOpen")].delta_m = {Vec3f(0, -0.020F, -0.005F)};
  return face;
}

/// Looks to the left, blinks with the left eye, and opens the jaw.
Track moving(std::size_t frames) {
  Track track(frames);
  for (std::size_t f = 0; f < frames; ++f) {
    const float t = static_cast<float>(f) / static_cast<float>(frames);
    track[f][shape("eyeLookOut_L")] = track[f][shape("eyeLookIn_R")] = t;
    track[f][shape("eyeBlink_L")] = t < 0.5F ? 0 : 1;
    track[f][shape("jawOpen")] = t < 0.5F ? 0 : 0.5F;
  }
  return track;
}

TEST(EyesAndLips, TheTruthItselfIsRight) {
  const EyesAndLipsMeter meter(lidded_face());
  const Track truth = moving(100);
  const Stretch stretch{truth, truth};
  const EyesAndLips m = meter.measure({&stretch, 1});
  EXPECT_NEAR(m.gaze_deg.value().median, 0, 1e-4);
  EXPECT_NEAR(m.gaze_deg->p90, 0, 1e-4);
  EXPECT_NEAR(m.openness_pearson.value(), 1, 1e-9);
  EXPECT_EQ(m.lip_gap_f1, 1);
}

TEST(EyesAndLips, AnglesAreOfOpenEyesAlone) {
  const EyesAndLipsMeter meter(lidded_face());
  Track truth(10), estimate(10);
  for (std::size_t f = 0; f < 10; ++f) {
    truth[f][shape("eyeLookUp_L")] = truth[f][shape("eyeLookUp_R")] = 0.5F;
    estimate[f] = truth[f];
    // The right eye is closed, and said to look elsewhere; the left one is off by f degrees.
    truth[f][shape("eyeBlink_R")] = 0.61F;
    estimate[f][shape("eyeLookOut_R")] = 1;
    estimate[f][shape("eyeLookUp_L")] +=
        static_cast<float>(kRadPerDeg / face::kEyeTurnRadPerUnit) * static_cast<float>(f);
  }
  const Stretch stretch{truth, estimate};
  const EyesAndLips m = meter.measure({&stretch, 1});
  EXPECT_NEAR(m.gaze_deg.value().median, 4.5, 1e-3);
  EXPECT_NEAR(m.gaze_deg->p90, 8.1, 1e-3);
}

TEST(EyesAndLips, DirectionsOfATrackerAreTakenBeforeItsWeights) {
  const EyesAndLipsMeter meter(lidded_face());
  const Track truth = moving(20);
  Track estimate(20);
  std::vector<EyeDirections> gaze;
  for (const face::BlendshapeWeights& weights : truth) gaze.push_back(face::eyes_rad(weights));
  const Stretch told{truth, estimate, gaze}, untold{truth, estimate};
  EXPECT_NEAR(meter.measure({&told, 1}).gaze_deg.value().p90, 0, 1e-3);
  EXPECT_GT(meter.measure({&untold, 1}).gaze_deg.value().p90, 10);
}

/// Yaw is less of an angle where the eye looks up: between two directions, not between two pairs of numbers.
TEST(EyesAndLips, AnAngleIsBetweenDirections) {
  const EyesAndLipsMeter meter(lidded_face());
  Track truth(1);
  truth[0][shape("eyeLookUp_L")] = truth[0][shape("eyeLookUp_R")] = 1;
  const auto pitch = static_cast<float>(face::kEyeTurnRadPerUnit);
  const std::vector<EyeDirections> gaze = {{Eigen::Vector2f(0.2F, pitch), Eigen::Vector2f(0.2F, pitch)}};
  const Stretch stretch{truth, truth, gaze};
  const double between =
      std::acos(std::sin(pitch) * std::sin(pitch) + std::cos(pitch) * std::cos(pitch) * std::cos(0.2F));
  EXPECT_NEAR(meter.measure({&stretch, 1}).gaze_deg.value().median, kDegPerRad * between, 1e-2);
}

TEST(EyesAndLips, LipsAreClosedBelowAMillimetre) {
  const EyesAndLipsMeter meter(lidded_face());
  Track truth(10), estimate(10);
  for (std::size_t f = 0; f < 10; ++f) {
    truth[f][shape("jawOpen")] = f < 4 ? 0.049F : 0.051F;     // 0.98 and 1.02 mm.
    estimate[f][shape("jawOpen")] = f < 2 || f == 9 ? 0 : 1;  // Two of four found, one of three wrong.
  }
  const Stretch stretch{truth, estimate};
  EXPECT_NEAR(meter.measure({&stretch, 1}).lip_gap_f1.value(), 2.0 * 2 / (4 + 3), 1e-12);
}

TEST(EyesAndLips, WhatTheTruthLacksIsAbsent) {
  const Track still(10), moves = moving(10);
  const Stretch of_still{still, moves};
  const EyesAndLips m = EyesAndLipsMeter(lidded_face()).measure({&of_still, 1});
  EXPECT_FALSE(m.gaze_deg) << "eyes that never turn were not recorded";
  EXPECT_FALSE(m.openness_pearson);
  Track open(10);
  for (auto& weights : open) weights[shape("jawOpen")] = 1;
  const Stretch of_open{open, open};
  EXPECT_FALSE(EyesAndLipsMeter(lidded_face()).measure({&of_open, 1}).lip_gap_f1);
  face::Face bare = lidded_face();
  bare.has_landmarks = false;
  const Stretch same{moves, moves};
  const EyesAndLips none = EyesAndLipsMeter(bare).measure({&same, 1});
  EXPECT_FALSE(none.gaze_deg || none.openness_pearson || none.lip_gap_f1);
}

TEST(EyesAndLips, KnowsTheBuiltInFace) {
  const EyesAndLipsMeter meter(builtin_face::make_builtin());
  face::BlendshapeWeights weights;
  EXPECT_NEAR(meter.openness(weights)[0], 1, 1e-5);
  EXPECT_LT(std::abs(meter.lip_gap_mm(weights)), 1);
  weights[shape("eyeBlink_L")] = weights[shape("jawOpen")] = 1;
  EXPECT_LT(meter.openness(weights)[0], 0.1);
  EXPECT_NEAR(meter.openness(weights)[1], 1, 0.01);
  EXPECT_GT(meter.lip_gap_mm(weights), 10);
}

}  // namespace
}  // namespace mien::measure::eyes_and_lips_test
