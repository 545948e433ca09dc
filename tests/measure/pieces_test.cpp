#include "mien/measure/pieces.h"

#include <gtest/gtest.h>

#include <vector>

namespace mien::measure::pieces_test {
namespace {

const std::size_t kJaw = face::shape("jawOpen"), kSmile = face::shape("mouthSmile_L");

TEST(Pieces, TellWhenAndWhereATakeWentWrong) {
  // 25 seconds whose first two are not evaluated; a smile that is not there from second 12 on.
  std::vector<take::TruthFrame> truth(25 * 60);
  std::vector<face::BlendshapeWeights> estimate(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].has_face = true;
    truth[i].evaluated = i >= 120;
    truth[i].weights[kJaw] = i < 720 ? 0.5F : 1;
    estimate[i][kJaw] = truth[i].weights[kJaw] - 0.1F;
    if (i >= 720) estimate[i][kSmile] = 0.3F;
  }
  truth[900].has_face = false;
  const std::vector<Piece> pieces = pieces_of(truth, estimate, {}, 10);
  ASSERT_EQ(pieces.size(), 2U) << "the last three seconds are less than half a piece";
  EXPECT_EQ(pieces[0].begin_s, 0);
  EXPECT_EQ(pieces[0].frames, 600U);
  EXPECT_NEAR(pieces[0].mse, 0.01 / face::kShapeCount, 1e-8);
  EXPECT_NEAR(pieces[0].mean_pose_mse, 0.25 / face::kShapeCount, 1e-8);
  EXPECT_EQ(pieces[0].ratio, 1);
  EXPECT_FALSE(pieces[0].biased_shape);
  EXPECT_EQ(pieces[1].begin_s, 10);
  EXPECT_EQ(pieces[1].frames, 599U);
  EXPECT_NEAR(pieces[1].mse, 0.1 / face::kShapeCount, 1e-8);
  EXPECT_NEAR(pieces[1].ratio, 10.0 / 4, 1e-5) << "ten times the error, of four times the motion";
  EXPECT_EQ(pieces[1].biased_shape, kSmile);
  EXPECT_NEAR(pieces[1].bias, 0.3, 1e-6);
}

TEST(Pieces, AShortTakeIsOnePiece) {
  std::vector<take::TruthFrame> truth(60);
  for (take::TruthFrame& frame : truth) frame.has_face = true;
  const std::vector<Piece> pieces = pieces_of(truth, std::vector<face::BlendshapeWeights>(60), {}, 600);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].frames, 60U);
  EXPECT_EQ(pieces[0].ratio, 0) << "nothing to compare with";
  EXPECT_TRUE(pieces_of({}, {}, {}, 600).empty());
}

}  // namespace
}  // namespace mien::measure::pieces_test
