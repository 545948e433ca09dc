#include "mien/study/merged_study.h"

#include <gtest/gtest.h>

#include "tests/study/eyewear/untrained.h"
#include "tests/tracker/tiny_model.h"

namespace mien::study::merged_study_test {
namespace {

MergedScene scene() {
  MergedScene out;
  out.rig = sensor::read_rig(project_path("rigs/imu_eyewear.toml")).value();
  const sensor::Rig imus = sensor::read_rig(project_path("rigs/default.toml")).value();
  out.imu_faults = virt::parse_faults(imus.faults_toml, "imus").value();
  out.eyewear_faults = virt::parse_eyewear_faults(test::eyewear_rig().faults_toml, "glasses").value();
  out.imu = tracker::test::tiny_causal_model(imus.face_sensor_names());
  out.eyewear = test::untrained();
  out.markers = test::all_markers();
  return out;
}

MergedRequest brief(unsigned threads) {
  return {.performers = 1,
          .seconds = 2,
          .prologue = performer::PrologueKind::brief,
          .lost = 0,
          .seed = 4,
          .threads = threads,
          .merge = {}};
}

TEST(MergedStudy, WhoExplainsMoreAnswersAndIsFollowedToTheBit) {
  // The IMUs' table says that with all sensors they explain all; the glasses have none.
  const auto by_imu = study_merged(brief(1), scene(), no_progress);
  ASSERT_TRUE(by_imu) << by_imu.error().message();
  const MergedPerson& person = by_imu->front();
  EXPECT_GT(person.merged.frames, 100U);
  EXPECT_EQ(person.merged.mse, person.imu.mse);
  EXPECT_NE(person.eyewear.mse, person.imu.mse) << "both are there";
  EXPECT_EQ(person.hand_overs, 0);
  for (const double share : person.by_eyewear) EXPECT_EQ(share, 0);

  MergedScene other = scene();
  std::swap(other.imu.confidence, other.eyewear.confidence);
  const auto by_eyewear = study_merged(brief(2), other, no_progress);
  ASSERT_TRUE(by_eyewear) << by_eyewear.error().message();
  EXPECT_EQ(by_eyewear->front().merged.mse, person.eyewear.mse);
  for (const double share : by_eyewear->front().by_eyewear) EXPECT_EQ(share, 1);
}

TEST(MergedStudy, IMUsThatFallSilentAreLostToTheirsAlone) {
  const auto all = study_merged(brief(1), scene(), no_progress);
  MergedRequest request = brief(1);
  request.lost = 3;
  const auto fewer = study_merged(request, scene(), no_progress);
  ASSERT_TRUE(all && fewer);
  EXPECT_NE(fewer->front().imu.mse, all->front().imu.mse);
  EXPECT_EQ(fewer->front().eyewear.mse, all->front().eyewear.mse);
  EXPECT_EQ(fewer->front().merged.frames, all->front().merged.frames);
  EXPECT_GT(fewer->front().confidence.expected_error(), 0);
  request.lost = 12;
  EXPECT_EQ(study_merged(request, scene(), no_progress).error().code, ErrorCode::bad_usage);
}

TEST(MergedStudy, RefusesNobodyAndAGridThatNoImuCarries) {
  MergedRequest nobody = brief(1);
  nobody.performers = 0;
  EXPECT_EQ(study_merged(nobody, scene(), no_progress).error().code, ErrorCode::bad_usage);
  MergedScene glasses = scene();
  glasses.rig.reference = "brow_inner_R";
  EXPECT_EQ(study_merged(brief(1), glasses, no_progress).error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::study::merged_study_test
