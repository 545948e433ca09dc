#include "mien/measure/metrics.h"

#include <gtest/gtest.h>

#include "mien/measure/evaluation.h"

namespace mien::measure::metrics_test {
namespace {

using face::shape;
using Track = std::vector<face::BlendshapeWeights>;

/// Two vertices and 68 landmarks on the first: jawOpen moves the first by 10 mm down, mouthLeft the second by
/// 4 mm.
face::Face two_vertex_face() {
  face::Face face;
  face.name = "two";
  face.neutral_m = {Vec3f(0, 0, 0), Vec3f(1, 0, 0)};
  for (const std::string_view name : face::kShapeNames) face.shapes.push_back({std::string(name), {}, {}});
  face.shapes[shape("jawOpen")].vertex = {0};
  face.shapes[shape("jawOpen")].delta_m = {Vec3f(0, -0.010F, 0)};
  face.shapes[shape("mouthLeft")].vertex = {1};
  face.shapes[shape("mouthLeft")].delta_m = {Vec3f(0.004F, 0, 0)};
  face.has_landmarks = true;
  face.landmarks.fill(0);
  face.regions = {{"skin", {1}}};
  return face;
}

Track constant(std::size_t frames, float jaw, float left) {
  Track track(frames);
  for (auto& w : track) {
    w[shape("jawOpen")] = jaw;
    w[shape("mouthLeft")] = left;
  }
  return track;
}

TEST(Metrics, ErrorsAreMillimetresOnTheMesh) {
  const Meter meter(two_vertex_face());
  const Track truth = constant(20, 0.5F, 0.0F);
  const Track estimate = constant(20, 0.7F, 0.5F);
  const Stretch stretch{truth, estimate};
  const Metrics m = meter.measure({&stretch, 1});
  EXPECT_EQ(m.frames, 20U);
  EXPECT_NEAR(m.pve_mm.mean, (2.0 + 2.0) / 2, 1e-4);  // 0.2 of 10 mm and 0.5 of 4 mm.
  EXPECT_NEAR(m.pve_mm.std, 0, 1e-5);
  EXPECT_NEAR(m.pve_face_mm->mean, 2.0, 1e-4);
  EXPECT_NEAR(m.lmk_mm->mean, 2.0, 1e-4);
  EXPECT_NEAR(m.mse, (0.04 + 0.25) / 53, 1e-6);
  EXPECT_NEAR(m.mse_observed, (0.04 + 0.25) / 42, 1e-6);
  EXPECT_NEAR(m.per_shape[shape("jawOpen")].mae, 0.2, 1e-6);
  EXPECT_FALSE(m.per_shape[shape("jawOpen")].pearson.has_value());
  EXPECT_FALSE(m.jitter_ratio.has_value());
  EXPECT_FALSE(m.blink_f1.has_value());
}

TEST(Metrics, HairAndClothesAreNotPartOfTheMean) {
  face::Face face = two_vertex_face();
  const std::uint32_t last = 7;
  for (std::uint32_t i = 2; i <= last; ++i)
    face.neutral_m.emplace_back(0.0F, 0.1F, 0.01F * static_cast<float>(i));
  face.triangles = {{0, 1, 1}, {2, 3, 4}, {5, 6, last}};
  face.parts = {{"skin", face::Material::skin, 0, 1},
                {"brows", face::Material::strands, 1, 1},
                {"shirt", face::Material::cloth, 2, 1}};
  const Track truth = constant(20, 0.5F, 0.0F), estimate = constant(20, 0.7F, 0.5F);
  const Stretch stretch{truth, estimate};
  EXPECT_EQ(Meter(face).measure({&stretch, 1}).pve_mm.mean,
            Meter(two_vertex_face()).measure({&stretch, 1}).pve_mm.mean);
  // Though a brow goes along with the skin.
  face.shapes[shape("mouthLeft")].vertex.push_back(3);
  face.shapes[shape("mouthLeft")].delta_m.emplace_back(0.008F, 0, 0);
  EXPECT_NEAR(Meter(face).measure({&stretch, 1}).pve_mm.mean, 2.0, 1e-4);
}

TEST(Metrics, BothSidesAreClipped) {
  const Meter meter(two_vertex_face());
  const Track truth = constant(5, 1.4F, 0);
  const Track estimate = constant(5, 1.0F, -0.3F);
  const Stretch stretch{truth, estimate};
  const Metrics m = meter.measure({&stretch, 1});
  EXPECT_EQ(m.mse, 0);
  EXPECT_EQ(m.pve_mm.mean, 0);
}

TEST(Metrics, MseObservedLeavesElevenOut) {
  int left_out = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) left_out += counts_in_mse_observed(k) ? 0 : 1;
  EXPECT_EQ(left_out, 11);
  Track truth(3);
  Track estimate(3);
  for (auto& w : estimate) w[shape("eyeWide_L")] = w[shape("eyeLookUp_R")] = w[shape("mouthShrugUpper")] = 1;
  const Stretch stretch{truth, estimate};
  const Metrics m = Meter(two_vertex_face()).measure({&stretch, 1});
  EXPECT_NEAR(m.mse, 3.0 / 53, 1e-6);
  EXPECT_EQ(m.mse_observed, 0);
}

TEST(Metrics, PearsonKnowsSignAndJitterKnowsScale) {
  Track truth(200);
  Track estimate(200);
  for (std::size_t f = 0; f < truth.size(); ++f) {
    const float w = 0.5F + 0.3F * std::sin(0.2F * static_cast<float>(f));
    truth[f][shape("jawOpen")] = w;
    estimate[f][shape("jawOpen")] = 1.0F - w / 2;
  }
  const Stretch stretch{truth, estimate};
  const Metrics m = Meter(two_vertex_face()).measure({&stretch, 1});
  EXPECT_NEAR(*m.per_shape[shape("jawOpen")].pearson, -1, 1e-5);
  EXPECT_NEAR(*m.jitter_ratio, 0.5, 1e-3);
}

TEST(Metrics, StretchesPoolLikeOneButGapsAreNoMotion) {
  const Meter meter(two_vertex_face());
  Track truth = constant(30, 0.2F, 0.1F);
  Track estimate = constant(30, 0.4F, 0.1F);
  for (std::size_t f = 15; f < 30; ++f) truth[f][shape("jawOpen")] = 0.9F;  // A jump, but across a gap.
  const std::span<const face::BlendshapeWeights> t(truth);
  const std::span<const face::BlendshapeWeights> e(estimate);
  const std::vector<Stretch> two = {{t.first(15), e.first(15)}, {t.subspan(15), e.subspan(15)}};
  const Metrics m = meter.measure(two);
  EXPECT_EQ(m.frames, 30U);
  EXPECT_NEAR(m.pve_mm.mean, 0.5 * (0.5 * 2 + 0.5 * 5), 1e-4);
  EXPECT_FALSE(m.jitter_ratio.has_value()) << "neither side moves within a stretch";
}

Track blinks(std::size_t frames, const std::vector<std::size_t>& at) {
  Track track(frames);
  for (const std::size_t b : at)
    for (std::size_t f = b; f < std::min(frames, b + 6); ++f)
      track[f][shape("eyeBlink_L")] = track[f][shape("eyeBlink_R")] = 0.9F;
  return track;
}

TEST(BlinkF1, MatchesOneToOneWithinTwoFrames) {
  const Track truth = blinks(200, {20, 60, 100, 140});
  const Track estimate = blinks(200, {22, 57, 100, 180});  // Hit, three frames off, hit, invented.
  const Stretch stretch{truth, estimate};
  EXPECT_NEAR(*blink_f1({&stretch, 1}), 2.0 * 4 / (8 + 8), 1e-9);
  const Stretch same{truth, truth};
  EXPECT_EQ(*blink_f1({&same, 1}), 1.0);
}

TEST(WinkF1, TellsWinksFromBlinks) {
  Track truth = blinks(200, {20, 100}), estimate = truth;
  const auto shut = [](Track& track, std::size_t shape, std::size_t from, std::size_t to) {
    for (std::size_t f = from; f < to; ++f) track[f][shape] = 0.9F;
  };
  const std::size_t left = shape("eyeBlink_L"), right = shape("eyeBlink_R");
  shut(truth, left, 60, 70);
  shut(truth, right, 150, 160);
  shut(estimate, left, 61, 69);
  const Stretch one_missed{truth, estimate};
  EXPECT_NEAR(*wink_f1({&one_missed, 1}), 2.0 * 1 / (2 + 1), 1e-9);
  shut(estimate, left, 150, 160);
  shut(estimate, right, 150, 160);
  EXPECT_NEAR(*wink_f1({&one_missed, 1}), 2.0 * 1 / (2 + 1), 1e-9) << "that is a blink";
  shut(truth, right, 126, 129);
  shut(truth, left, 130, 134);
  shut(estimate, right, 126, 129);
  shut(estimate, left, 130, 134);
  EXPECT_NEAR(*wink_f1({&one_missed, 1}), 2.0 * 1 / (2 + 1), 1e-9) << "a lid that is early does not wink";
  const Track blinking = blinks(200, {20});
  const Stretch none{blinking, blinking};
  EXPECT_FALSE(wink_f1({&none, 1}));
}

TEST(BlinkF1, IsAbsentOnlyWhereNobodyBlinks) {
  const Track open = blinks(200, {});
  const Track blinking = blinks(200, {20});
  const Stretch neither{open, open};
  EXPECT_FALSE(blink_f1({&neither, 1}));
  const Stretch invented{open, blinking};
  EXPECT_EQ(blink_f1({&invented, 1}), 0.0);
  const Stretch missed{blinking, open};
  EXPECT_EQ(blink_f1({&missed, 1}), 0.0);
}

TEST(Evaluate, LeavesOutPrologueAndLostFaces) {
  const Meter meter(two_vertex_face());
  TakeEstimates take;
  take.take = "t";
  for (int f = 0; f < 100; ++f) {
    take::TruthFrame truth;
    truth.time = DeviceTime(frame_offset(f));
    truth.weights[shape("jawOpen")] = 0.5F;
    truth.evaluated = f >= 20;
    truth.has_face = f < 60 || f >= 70;
    take.truth.push_back(truth);
    face::BlendshapeWeights estimate;
    estimate[shape("jawOpen")] = f >= 20 && truth.has_face ? 0.6F : 0.0F;
    take.model.push_back(estimate);
  }
  const auto evaluation = evaluate(meter, {take}, face::BlendshapeWeights{});
  ASSERT_TRUE(evaluation.has_value());
  EXPECT_EQ(evaluation->frames, 70U);
  EXPECT_NEAR(evaluation->model.per_shape[shape("jawOpen")].mae, 0.1, 1e-6);
  EXPECT_NEAR(evaluation->mean_pose.per_shape[shape("jawOpen")].mae, 0.5, 1e-6);
  EXPECT_NEAR(evaluation->hold_last.per_shape[shape("jawOpen")].mae, 0, 1e-6);
  EXPECT_FALSE(evaluation->ridge.has_value());

  take.truth.resize(20);
  take.model.resize(20);
  EXPECT_EQ(evaluate(meter, {take}, {}).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::measure::metrics_test
