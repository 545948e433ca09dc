#include "lab/imu/placement/paper_sites.h"

#include <gtest/gtest.h>

#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::paper_sites_test {
namespace {

TEST(RankCorrelation, IsSpearmans) {
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {10, 20, 30, 1000}), 1);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {8, 6, 4, 2}), -1);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3}, {5, 5, 5}), 0);
  // Without ties 1 - 6 sum d^2 / (n (n^2 - 1)).
  EXPECT_NEAR(rank_correlation({1, 2, 3, 4, 5}, {2, 1, 3, 5, 4}), 1 - 6.0 * 4 / (5 * 24), 1e-12);
}

TEST(StudyPaperSites, IsTheSameOnAnyNumberOfThreads) {
  const sensor::Rig rig = sensor::read_rig(project_path("rigs/candidates.toml")).value();
  PaperSitesRequest request{.performers = 2, .threads = 1};
  const auto one = study_paper_sites(request, rig, no_progress);
  ASSERT_TRUE(one) << one.error().message();
  request.threads = 2;
  const auto two = study_paper_sites(request, rig, no_progress);
  ASSERT_TRUE(two);
  ASSERT_EQ(one->sites.size(), kPaperSites.size());
  for (std::size_t i = 0; i < one->sites.size(); ++i) {
    EXPECT_EQ(one->sites[i].acceleration, two->sites[i].acceleration);
    EXPECT_EQ(one->sites[i].rotation_deg, two->sites[i].rotation_deg);
    EXPECT_GT(one->sites[i].acceleration, 0) << one->sites[i].site.name;
    EXPECT_GT(one->sites[i].accelerometer, 0);
  }
  EXPECT_LE(std::abs(one->acceleration.all), 1);
  // The chin moves most of all when the jaw does.
  EXPECT_GT(one->sites.back().acceleration, one->sites[8].acceleration);
}

TEST(StudyPaperSites, NeedsTheTablesSites) {
  const auto none = study_paper_sites({.performers = 1}, virt::test::three_sensors(), no_progress);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::lab::paper_sites_test
