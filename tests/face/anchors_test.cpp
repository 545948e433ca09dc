#include "mien/face/anchors.h"

#include <gtest/gtest.h>

#include <set>

namespace mien::face::anchors_test {
namespace {

TEST(Anchors, EachAsksForSomethingThatNoOtherAsksFor) {
  for (const std::span<const Anchor> all : {anchors(), range_of_motion()}) {
    std::set<std::string_view> names;
    for (const Anchor& one : all) {
      EXPECT_TRUE(names.insert(one.name).second) << one.name;
      EXPECT_FALSE(one.prompt.empty()) << one.name;
      EXPECT_NE(one.target, BlendshapeWeights()) << one.name;
      for (const Anchor& other : all)
        if (&other != &one) {
          EXPECT_NE(one.target, other.target) << one.name << " and " << other.name;
        }
    }
  }
}

TEST(Anchors, TheRangeAsksForBothSidesUnlessItNamesOne) {
  const auto named = [](std::string_view name) {
    for (const Anchor& one : range_of_motion())
      if (one.name == name) return one.target;
    return BlendshapeWeights();
  };
  BlendshapeWeights both, left;
  both[shape("mouthSmile_L")] = both[shape("mouthSmile_R")] = left[shape("mouthSmile_L")] = 1;
  EXPECT_EQ(named("mouthSmile"), both);
  EXPECT_EQ(named("mouthSmile_L"), left);
}

}  // namespace
}  // namespace mien::face::anchors_test
