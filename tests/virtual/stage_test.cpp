// What a request for a performance becomes.
#include "mien/virtual/stage.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstddef>

#include "mien/core/files.h"
#include "mien/virtual/imu/worn_imus.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::stage_test {
namespace {

const std::vector<SkinSite>& sites_of(const Stage& stage) {
  return dynamic_cast<const WornImus&>(*stage.worn).sites();
}

/// The stage that a request sets.
class SetStage : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_file(folder_ / "rig.toml", test::kRig));
    request_.rig = folder_ / "rig.toml";
    request_.motion = test::talking(45);
    request_.script_name = "talking";
  }
  mien::test::Folder folder_;
  StageRequest request_;
};

TEST_F(SetStage, IsTheSameForTheSameSeed) {
  const Stage one = set_stage(request_).value();
  const Stage same = set_stage(request_).value();
  request_.seed = 2;
  const Stage other = set_stage(request_).value();
  EXPECT_EQ(one.rig_toml, test::kRig);
  EXPECT_FALSE(one.lab);
  EXPECT_EQ(sites_of(one).size(), 3U);
  EXPECT_EQ(one.motion.motion.frames.size(), same.motion.motion.frames.size());
  Random a = one.devices;
  Random b = same.devices;
  Random c = other.devices;
  const std::uint64_t drawn = a.bits();
  EXPECT_EQ(drawn, b.bits());
  EXPECT_NE(drawn, c.bits());
}

TEST_F(SetStage, NodsInItsPrologueButInLab) {
  EXPECT_GT(set_stage(request_)->motion.times.nod.end_s, set_stage(request_)->motion.times.nod.begin_s);
  request_.devices = "lab";
  const Stage lab = set_stage(request_).value();
  EXPECT_TRUE(lab.lab);
  EXPECT_EQ(lab.motion.times.nod.end_s, lab.motion.times.nod.begin_s);
}

/// How far a smile turns the skin under the first sensor on two stages apart, rad.
double apart(const Stage& one, const Stage& other) {
  face::BlendshapeWeights smile;
  smile[face::shape("mouthSmile_L")] = smile[face::shape("mouthSmile_R")] = 0.8F;
  double most = 0;
  for (std::size_t s = 0; s < sites_of(one).size(); ++s)
    most =
        std::max(most, angle_between(sites_of(one)[s].rotation(smile), sites_of(other)[s].rotation(smile)));
  return most;
}

TEST_F(SetStage, DrawsSkinUnlikeTheFaces) {
  request_.devices = "lab";
  const Stage own = set_stage(request_).value();
  EXPECT_EQ(apart(own, set_stage(request_).value()), 0);
  request_.unlike = 0.1;
  const double little = apart(own, set_stage(request_).value());
  request_.unlike = 1;
  const Stage unlike = set_stage(request_).value();
  EXPECT_GT(little, 0);
  EXPECT_GT(apart(own, unlike), 4 * little);
  EXPECT_EQ(apart(unlike, set_stage(request_).value()), 0);  // The seed draws it.
  request_.seed = 2;
  EXPECT_GT(apart(unlike, set_stage(request_).value()), little);
}

TEST_F(SetStage, RefusesUnlikeSkinUnderGlasses) {
  request_.rig = project_path("rigs/eyewear.toml");
  request_.unlike = 1;
  const auto refused = set_stage(request_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_THAT(refused.error().message(), ::testing::HasSubstr("glued"));
}

TEST_F(SetStage, RefusesAMotionWithoutFrames) {
  request_.motion = face::Motion{};
  const auto refused = set_stage(request_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_THAT(refused.error().message(), ::testing::HasSubstr("talking"));
}

TEST_F(SetStage, RefusesSensorsOfSeveralKinds) {
  request_.rig = project_path("rigs/imu_eyewear.toml");
  const auto refused = set_stage(request_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mien::virt::stage_test
