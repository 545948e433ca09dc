#include "mien/solve/region_tally.h"

#include <gtest/gtest.h>

namespace mien::solve::region_tally_test {
namespace {

constexpr auto kJaw = static_cast<std::size_t>(face::ShapeRegion::jaw);
constexpr auto kBrows = static_cast<std::size_t>(face::ShapeRegion::brows);

TEST(RegionsWithin, AreThoseWhoseMeanErrorIsATenthOrLess) {
  face::BlendshapeWeights truth, estimate;
  // Four shapes of the jaw: an error of 0.4 in one of them is 0.1 in the mean.
  truth[face::shape("jawOpen")] = 0.5F;
  estimate[face::shape("jawOpen")] = 0.125F;
  estimate[face::shape("browInnerUp_L")] = 0.65F;  // Of six.
  const auto within = regions_within(estimate, truth);
  EXPECT_TRUE(within[kJaw]);
  EXPECT_FALSE(within[kBrows]);
  truth[face::shape("jawLeft")] = 0.05F;
  EXPECT_FALSE(regions_within(estimate, truth)[kJaw]) << "errors of either sign add up";
}

TEST(RegionTally, CountsEachRegionAndAllOfThem) {
  RegionTally one, sum;
  face::OutputFrame frame;
  frame.region_confidence.fill(0.8F);
  frame.weights[face::shape("jawOpen")] = 1;
  one.add(frame, {});
  sum.add(one);
  sum.add(one);
  EXPECT_NEAR(sum.each[kJaw].expected_error(), 0.8, 1e-6);
  EXPECT_NEAR(sum.each[kBrows].expected_error(), 0.2, 1e-6);
  EXPECT_NEAR(sum.all.expected_error(), 0, 1e-6) << "four of five, as was said";
  EXPECT_EQ(sum.all.bins()[8].frames, 10);
  EXPECT_EQ(sum.roc.area(), 0.5);
}

TEST(ExpectedRegionError, IsOfEvaluatedFramesWhoseConfidenceIsKnown) {
  measure::TakeEstimates take{.take = "one", .truth = {}, .model = {}, .ridge = {}};
  take.truth.resize(4);
  take.model.resize(4);
  EXPECT_FALSE(expected_region_error({take})) << "it has none";
  take.region_confidence.resize(4);
  EXPECT_FALSE(expected_region_error({take})) << "nothing is known";
  for (auto& frame : take.region_confidence) frame[kJaw] = 0.75F;
  take.model[0][face::shape("jawOpen")] = 1;  // One of four is wrong, as was said.
  EXPECT_NEAR(expected_region_error({take}).value(), 0, 1e-6);
  take.truth[1].evaluated = false;
  EXPECT_NEAR(expected_region_error({take}).value(), 0.75 - 2.0 / 3, 1e-6);
  take.region_confidence[3][kBrows] = 0.5F;
  EXPECT_NEAR(expected_region_error({take, take}).value(), (3 * (0.75 - 2.0 / 3) + 0.5) / 4, 1e-6);
}

}  // namespace
}  // namespace mien::solve::region_tally_test
