#include "mien/performer/named_pose.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace mien::performer::named_pose_test {
namespace {

using ::testing::HasSubstr;

TEST(NamedPose, EveryPlainNameIsAPoseOfItsOwn) {
  const std::vector<std::string> names = plain_pose_names();
  EXPECT_GE(names.size(), 12U);
  std::vector<face::BlendshapeWeights> seen;
  for (const std::string& name : names) {
    const auto pose = named_pose(name);
    ASSERT_TRUE(pose.has_value()) << name;
    EXPECT_EQ(std::ranges::find(seen, pose->weights), seen.end()) << name;
    seen.push_back(pose->weights);
  }
  EXPECT_EQ(named_pose("neutral")->weights, face::BlendshapeWeights{});
  EXPECT_GT(named_pose("smile")->weights[face::shape("mouthSmile_L")], 0.5F);
}

TEST(NamedPose, KnowsTheLibraryToo) {
  EXPECT_EQ(named_pose("tongue_out")->tongue_out, 1);
  EXPECT_GT(named_pose("wink_R")->weights[face::shape("eyeBlink_R")], 0.9F);
}

TEST(NamedPose, RefusesOthers) {
  EXPECT_THAT(named_pose("smiel").error().message(), HasSubstr("did you mean smile?"));
  EXPECT_THAT(named_pose("xyzzyxyzzy").error().message(), HasSubstr("such as neutral, smile"));
  EXPECT_FALSE(named_pose("").has_value());
}

}  // namespace
}  // namespace mien::performer::named_pose_test
