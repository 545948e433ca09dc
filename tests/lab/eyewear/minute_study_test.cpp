#include "lab/eyewear/minute_study.h"

#include <gtest/gtest.h>

#include "mien/builtin_face/builtin_face.h"
#include "mien/synthetic/eyewear/worn_glasses.h"
#include "tests/lab/eyewear/untrained.h"

namespace mien::lab::minute_study_test {
namespace {

using test::untrained;

const sensor::Rig& rig() {
  return test::eyewear_rig();
}

const builtin_face::MarkerSet& markers() {
  return test::all_markers();
}

SensorsRequest brief(unsigned threads) {
  SensorsRequest request;
  request.wearers = 1;
  request.test_s = 1;
  request.seed = 3;
  request.threads = threads;
  return request;
}

TEST(MinuteStudy, MeasuresMethodsAndConditionsOnAnyNumberOfThreads) {
  const auto one = study_minute(brief(1), rig(), markers(), untrained(), {}, no_progress);
  const auto two = study_minute(brief(2), rig(), markers(), untrained(), {}, no_progress);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(two) << two.error().message();
  ASSERT_EQ(one->methods.size(), 4u);
  ASSERT_EQ(one->conditions.size(), 6u);
  const double neutral_mm = one->methods[0].overall.all.mean_mm;
  EXPECT_GT(neutral_mm, 0.3);
  for (std::size_t m = 0; m < 4; ++m) {
    EXPECT_EQ(one->methods[m].tests.size(), kTests);
    EXPECT_EQ(one->methods[m].overall.all.mean_mm, two->methods[m].overall.all.mean_mm);
    EXPECT_EQ(one->conditions[m].overall.all.mean_mm, two->conditions[m].overall.all.mean_mm);
  }
  // Sensors were heard: what the network answers depends on them, and on how the glasses sit.
  EXPECT_NE(one->methods[2].overall.all.mean_mm, neutral_mm);
  EXPECT_NE(one->methods[2].overall.all.mean_mm, one->methods[3].overall.all.mean_mm);
  EXPECT_NE(one->conditions[0].overall.all.mean_mm, one->conditions[1].overall.all.mean_mm);
}

TEST(MinuteStudy, TakesAnotherFaceAndItsMotions) {
  MinuteScene scene;
  scene.face = builtin_face::make_builtin();
  scene.motions.push_back(synthetic::range_of_motion(Random(3)));
  scene.motions.back().frames.resize(120);
  const auto study = study_minute(brief(2), rig(), markers(), untrained(), scene, no_progress);
  ASSERT_TRUE(study) << study.error().message();
  ASSERT_EQ(study->methods[0].tests.size(), 1u);
  EXPECT_GT(study->methods[0].overall.all.mean_mm, 0.1) << "brows go up";
  scene.motions.emplace_back();
  EXPECT_FALSE(study_minute(brief(2), rig(), markers(), untrained(), scene, no_progress));
}

TEST(MinuteStudy, RefusesModelsOfOtherMarkers) {
  eyewear::MarkerNetworkFile other = untrained();
  std::swap(other.markers[0], other.markers[1]);
  const auto study = study_minute(brief(1), rig(), markers(), other, {}, no_progress);
  ASSERT_FALSE(study);
  EXPECT_EQ(study.error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::lab::minute_study_test
