#include "lab/imu/placement/misplacement.h"

#include <gtest/gtest.h>

#include "lab/imu/sensor_bound.h"
#include "mien/builtin_face/builtin_face.h"
#include "tests/project_path.h"

namespace mien::lab::misplacement_test {
namespace {

using Eigen::MatrixXd;

struct Worn {
  std::vector<SensorCandidate> set =
      candidates_of(sensor::read_rig(project_path("rigs/default.toml")).value()).value();
  const face::Face& face = builtin_face::default_builtin();
  MatrixXd gram = placement_gram(face, PlacementObjective::vertex);
};

TEST(MismatchedSquaredError, IsTheBoundWhereTheBeliefIsTrueAndMoreElsewhere) {
  const Worn worn;
  const MatrixXd slopes =
      virt::rotation_slopes(virt::skin_sites(worn.face, sites_rig(worn.set)).value(), kBoundStep);
  const double bound = expected_squared_error(worn.gram, posterior_covariance(slopes, 0.1, kRadPerDeg));
  EXPECT_NEAR(mismatched_squared_error(worn.gram, slopes, slopes, 0.1, kRadPerDeg) / bound, 1, 1e-9);
  // Whoever knows the truth does at least as well, whatever it is.
  for (const double factor : {0.5, 0.9, 1.1, 2.0}) {
    const MatrixXd truth = factor * slopes;
    EXPECT_GT(mismatched_squared_error(worn.gram, slopes, truth, 0.1, kRadPerDeg),
              expected_squared_error(worn.gram, posterior_covariance(truth, 0.1, kRadPerDeg)));
  }
}

TEST(MisplacementCosts, NothingForNothingAndMoreForMore) {
  const Worn worn;
  const auto none =
      misplacement_costs(worn.face, worn.set, worn.gram, {}, {.shift_m = 0, .directions = 2, .turn_rad = 0});
  ASSERT_TRUE(none) << none.error().message();
  ASSERT_EQ(none->size(), worn.set.size());
  for (const SiteMisplacement& site : *none)
    for (const MisplacementCost& cost : {site.shifted, site.shifted_known, site.turned, site.tilted}) {
      EXPECT_NEAR(cost.mean, 0, 1e-6) << site.sensor;
      EXPECT_NEAR(cost.worst, 0, 1e-6) << site.sensor;
    }
  const auto some = misplacement_costs(worn.face, worn.set, worn.gram, {}, {.directions = 4});
  const auto more =
      misplacement_costs(worn.face, worn.set, worn.gram, {}, {.directions = 4, .turn_rad = 20 * kRadPerDeg});
  ASSERT_TRUE(some && more);
  double shifted = 0;
  for (std::size_t s = 0; s < worn.set.size(); ++s) {
    const SiteMisplacement& site = (*some)[s];
    EXPECT_EQ(site.sensor, worn.set[s].name);
    // To and fro cancel to first order: on average a wrong belief costs.
    EXPECT_GT(site.turned.mean, 0) << site.sensor;
    EXPECT_GT(site.tilted.mean, 0) << site.sensor;
    EXPECT_GE(site.shifted.worst, site.shifted.mean);
    EXPECT_GT((*more)[s].turned.mean, site.turned.mean) << site.sensor;
    shifted += site.shifted.mean;
  }
  EXPECT_GT(shifted, 0);
}

}  // namespace
}  // namespace mien::lab::misplacement_test
