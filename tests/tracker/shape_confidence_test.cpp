#include "mien/tracker/shape_confidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/tracker/tiny_model.h"

namespace mien::tracker::shape_confidence_test {
namespace {

using ::testing::Each;

constexpr auto kJaw = static_cast<std::size_t>(face::ShapeRegion::jaw);
constexpr auto kBrows = static_cast<std::size_t>(face::ShapeRegion::brows);

Coverage all_covered() {
  Coverage coverage;
  coverage.fill(1);
  return coverage;
}

/// Every shape: 0.75 below a weight of a half and 0.25 from there on; with little coverage nothing.
model::ConfidenceTable table() {
  model::ConfidenceTable out;
  out.coverage_edges = {0.5F};
  out.value_edges = {0.5F};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    out.explained.insert(out.explained.end(), {0, 1});
    out.within.insert(out.within.end(), {0, 0, 0.75F, 0.25F});
  }
  return out;
}

TEST(RegionScores, AreTheMeanLogOddsOfTheirShapes) {
  const ShapeConfidence confidence(table());
  face::BlendshapeWeights weights;
  weights[face::shape("jawOpen")] = 0.9F;
  const RegionScores scores = confidence.region_scores(all_covered(), weights);
  EXPECT_NEAR(scores[kBrows], std::log(3), 1e-5);
  // Three of the jaw's four at rest.
  EXPECT_NEAR(scores[kJaw], (3 * std::log(3.0) - std::log(3.0)) / 4, 1e-5);
  EXPECT_NEAR(confidence.region_scores({}, weights)[kJaw], std::log(0.01 / 0.99), 1e-4) << "held";
  EXPECT_THAT(ShapeConfidence(std::nullopt).region_scores(all_covered(), weights), Each(0));
}

TEST(RegionConfidence, IsTheMapOfTheScore) {
  model::ConfidenceTable with = table();
  with.regions.emplace();
  (*with.regions)[kJaw] = {-1, 2};
  (*with.regions)[kBrows] = {0, 1};
  const ShapeConfidence confidence(with);
  face::OutputFrame frame;
  frame.weights[face::shape("jawOpen")] = 0.9F;
  confidence.write(all_covered(), frame);
  EXPECT_NEAR(frame.region_confidence[kBrows], 0.75, 1e-6);
  EXPECT_NEAR(frame.region_confidence[kJaw], 1 / (1 + std::exp(1 - std::log(3.0))), 1e-6);
  EXPECT_EQ(frame.region_confidence[static_cast<std::size_t>(face::ShapeRegion::eyes)], 0.5F);
}

TEST(RegionConfidence, IsUnknownWithoutMapsAndChangesNothingElse) {
  model::ConfidenceTable with = table();
  with.regions.emplace();
  face::OutputFrame without, known;
  without.region_confidence.fill(0.3F);  // Of a frame before.
  const Explained one = ShapeConfidence(table()).write(all_covered(), without);
  const Explained other = ShapeConfidence(with).write(all_covered(), known);
  EXPECT_THAT(without.region_confidence, Each(0));
  EXPECT_THAT(known.region_confidence, Each(0.5F));
  EXPECT_EQ(without.confidence, known.confidence);
  EXPECT_EQ(without.provenance, known.provenance);
  EXPECT_EQ(one, other);
  ShapeConfidence(std::nullopt).write(all_covered(), known);
  EXPECT_THAT(known.region_confidence, Each(0));
}

}  // namespace
}  // namespace mien::tracker::shape_confidence_test
