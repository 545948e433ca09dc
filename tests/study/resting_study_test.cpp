#include "mien/study/resting_study.h"

#include <gtest/gtest.h>

namespace mien::study::resting_study_test {
namespace {

using face::shape;

TEST(RestingStudy, RefusesTooFewWearersAndTooShortPerformances) {
  EXPECT_EQ(study_resting({.wearers = 2}, no_progress).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(study_resting({.seconds = 60}, no_progress).error().code, ErrorCode::bad_usage);
}

TEST(RestingStudy, EveryKindOfFaceIsHelpedAndNoneHurt) {
  const RestingRequest request{.wearers = 9, .seconds = 75, .seed = 5, .threads = 1};
  const auto study = study_resting(request, no_progress);
  ASSERT_TRUE(study);
  ASSERT_EQ(study->results.size(), 3 * kRestingKindNames.size());
  for (const RestingResult& r : study->results) {
    SCOPED_TRACE(std::string(r.script) + " " +
                 std::string(kRestingKindNames.at(static_cast<std::size_t>(r.kind))));
    if (r.kind == RestingKind::usual) {
      EXPECT_LT(r.resting.after, 0.01);
      EXPECT_LT(r.active.after, 1.05 * r.active.before);
    } else {
      EXPECT_GT(r.resting.before, 0.1);
      EXPECT_LT(r.resting.after, 0.2 * r.resting.before);
      EXPECT_NEAR(r.curve[0], r.resting.before, 0.05);  // Not before the tenth second.
      EXPECT_LT(r.curve[5], 0.2 * r.curve[0]);
    }
  }
  // A smile is kept for 20 s at least, and one above a half for as long as it is made.
  ASSERT_EQ(study->smiles.size(), 3U);
  for (const LongSmile& smile : study->smiles) EXPECT_NEAR(smile.shown.at(7), smile.smile, 1e-6);
  EXPECT_NEAR(study->smiles[2].shown.at(11), 0.8, 1e-6);
}

TEST(RestingStudy, TheSameRequestGivesTheSameNumbersInAnyNumberOfThreads) {
  RestingRequest request{.wearers = 3, .seconds = 61, .seed = 6, .threads = 1};
  const auto one = study_resting(request, no_progress);
  request.threads = 3;
  const auto three = study_resting(request, no_progress);
  ASSERT_TRUE(one && three);
  for (std::size_t i = 0; i < one->results.size(); ++i) {
    EXPECT_EQ(one->results[i].all.after, three->results[i].all.after);
    EXPECT_EQ(one->results[i].curve, three->results[i].curve);
  }
}

TEST(RestingStudy, OfARecordingTheLowerThirdIsToldWithTheStepAndWithout) {
  face::Motion motion;
  for (int n = 0; n <= 60 * 60; ++n) {
    face::MotionFrame frame;
    frame.time_s = n / 60.0;
    frame.weights[shape("browInnerUp_L")] = 16.0F / 63;
    frame.weights[shape("jawOpen")] = n % 2 == 0 ? 0.2F : 0.8F;
    motion.frames.push_back(frame);
  }
  const std::vector<BeforeAfter> rests = rests_of(motion);
  ASSERT_EQ(rests.size(), face::kShapeCount);
  EXPECT_NEAR(rests[shape("browInnerUp_L")].before, 16 / 63.0, 1e-6);
  EXPECT_NEAR(rests[shape("browInnerUp_L")].after, 0, 1e-6);
  EXPECT_EQ(rests[shape("jawOpen")].after, rests[shape("jawOpen")].before);
  EXPECT_EQ(rests[shape("mouthSmile_L")].after, 0);
}

}  // namespace
}  // namespace mien::study::resting_study_test
