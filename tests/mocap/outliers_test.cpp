#include "mien/mocap/outliers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::mocap::outliers_test {
namespace {

Eigen::MatrixXd noise(Eigen::Index rows) {
  Random random(1);
  Eigen::MatrixXd out(rows, 3);
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) out(i, c) = random.uniform(-1, 1);
  return out;
}

TEST(RejectOutliers, KeepsWhatIsInLine) {
  const Kept kept = reject_outliers(noise(200));
  EXPECT_EQ(kept.rejected, 0u);
  EXPECT_EQ(kept.rows.size(), 200u);
}

TEST(RejectOutliers, RejectsASampleForOneOfItsNumbers) {
  Eigen::MatrixXd rows = noise(200);
  rows(17, 2) = 9;
  rows(41, 0) = std::nan("");
  const Kept kept = reject_outliers(rows);
  EXPECT_EQ(kept.rejected, 2u);
  for (const std::size_t row : kept.rows) EXPECT_TRUE(row != 17 && row != 41);
}

TEST(RejectOutliers, TakesNumbersThatDoNotMove) {
  EXPECT_EQ(reject_outliers(Eigen::MatrixXd::Constant(10, 2, 3.5)).rejected, 0u);
  EXPECT_EQ(reject_outliers(Eigen::MatrixXd(0, 3)).rows.size(), 0u);
}

}  // namespace
}  // namespace mien::mocap::outliers_test
