#include "lab/imu/placement/placement_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "lab/imu/sensor_bound.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/random.h"
#include "tests/project_path.h"

namespace mien::lab::placement_bound_test {
namespace {

using Eigen::MatrixXd;

MatrixXd drawn_slopes(Eigen::Index rows, std::uint64_t seed) {
  Random random(seed);
  MatrixXd slopes(rows, static_cast<Eigen::Index>(face::kShapeCount));
  for (Eigen::Index r = 0; r < slopes.rows(); ++r)
    for (Eigen::Index k = 0; k < slopes.cols(); ++k) slopes(r, k) = 0.1 * random.normal();
  return slopes;
}

MatrixXd even_gram() {
  return MatrixXd::Identity(static_cast<Eigen::Index>(face::kShapeCount),
                            static_cast<Eigen::Index>(face::kShapeCount)) /
         static_cast<double>(face::kShapeCount);
}

/// A grid of the real face and what it feels.
struct GridOnFace {
  std::vector<SensorCandidate> candidates = dense_candidates(0.02);
  MatrixXd slopes, gram;
};
const GridOnFace& grid() {
  static const GridOnFace one = [] {
    GridOnFace made;
    const face::Face& face = builtin_face::default_builtin();
    made.slopes =
        virt::rotation_slopes(virt::skin_sites(face, sites_rig(made.candidates)).value(), kBoundStep);
    made.gram = placement_gram(face, PlacementObjective::vertex);
    return made;
  }();
  return one;
}

TEST(PosteriorWith, IsTheDirectInverse) {
  const double prior = 0.1, noise_rad = 0.02;
  const MatrixXd slopes = drawn_slopes(12, 1);
  MatrixXd step_by_step = posterior_covariance(slopes.topRows(3), prior, noise_rad);
  for (const auto& [first, rows] : {std::pair{3, 3}, std::pair{6, 6}})
    step_by_step = posterior_with(step_by_step, slopes.middleRows(first, rows), noise_rad);
  const MatrixXd at_once = posterior_covariance(slopes, prior, noise_rad);
  EXPECT_LT((step_by_step - at_once).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ErrorReductions, AreWhatAddingTheSensorTells) {
  const double noise_rad = 0.02;
  const MatrixXd slopes = drawn_slopes(9, 2);
  const MatrixXd covariance = posterior_covariance(drawn_slopes(6, 3), 0.1, noise_rad);
  const std::vector<double> reductions = error_reductions(even_gram(), covariance, slopes, noise_rad);
  ASSERT_EQ(reductions.size(), 3U);
  const double before = expected_squared_error(even_gram(), covariance);
  for (int i = 0; i < 3; ++i) {
    const double after = expected_squared_error(
        even_gram(), posterior_with(covariance, slopes.middleRows(3 * i, 3), noise_rad));
    EXPECT_NEAR(reductions[static_cast<std::size_t>(i)], 1 - after / before, 1e-12);
    EXPECT_GT(reductions[static_cast<std::size_t>(i)], 0);
  }
}

TEST(BoundPlacement, EverySensorTellsMore) {
  for (const bool one_sided : {false, true}) {
    const auto bound =
        bound_placement(grid().candidates, grid().slopes, grid().gram, {.one_sided = one_sided, .most = 9});
    ASSERT_TRUE(bound) << bound.error().message();
    ASSERT_EQ(bound->sets.size(), 9U);
    double last = expected_squared_error(grid().gram, prior_covariance(0.10));
    for (std::size_t i = 0; i < bound->sets.size(); ++i) {
      const PlacementSet& set = bound->sets[i];
      EXPECT_EQ(set.chosen.size(), i + 1);
      EXPECT_LT(set.squared_error, last);
      last = set.squared_error;
      // As if all had been there from the beginning.
      MatrixXd rows(3 * static_cast<Eigen::Index>(set.chosen.size()), grid().slopes.cols());
      for (std::size_t c = 0; c < set.chosen.size(); ++c)
        rows.middleRows(3 * static_cast<Eigen::Index>(c), 3) =
            grid().slopes.middleRows(3 * static_cast<Eigen::Index>(set.chosen[c]), 3);
      const MatrixXd at_once = posterior_covariance(rows, 0.10, kRadPerDeg);
      EXPECT_NEAR(expected_squared_error(grid().gram, at_once) / set.squared_error, 1, 1e-9);
      for (std::size_t a = 0; a < set.chosen.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
          EXPECT_GE(
              (grid().candidates[set.chosen[a]].position_m - grid().candidates[set.chosen[b]].position_m)
                  .norm(),
              kModuleApartM);
    }
    EXPECT_EQ(bound->of_size(5), &bound->sets[4]);
    EXPECT_EQ(bound->of_size(10), nullptr);
  }
}

TEST(BoundPlacement, SetsAreSymmetricUnlessOneSided) {
  const auto both = bound_placement(grid().candidates, grid().slopes, grid().gram, {.most = 8});
  ASSERT_TRUE(both);
  const std::vector<std::size_t> mirror = mirror_candidates(grid().candidates);
  for (const PlacementSet& set : both->sets)
    for (const std::size_t i : set.chosen)
      EXPECT_NE(std::ranges::find(set.chosen, mirror[i]), set.chosen.end()) << grid().candidates[i].name;
  const auto each =
      bound_placement(grid().candidates, grid().slopes, grid().gram, {.one_sided = true, .most = 8});
  ASSERT_TRUE(each);
  // A single free sensor is at least as good as one on the midline.
  EXPECT_LE(each->sets.front().squared_error, both->sets.front().squared_error);
}

TEST(ErrorReductions, OfLeftAndRightAreAlike) {
  const std::vector<double> alone =
      error_reductions(grid().gram, prior_covariance(0.10), grid().slopes, kRadPerDeg);
  const std::vector<std::size_t> mirror = mirror_candidates(grid().candidates);
  const double most = *std::ranges::max_element(alone);
  for (std::size_t i = 0; i < mirror.size(); ++i)
    EXPECT_NEAR(alone[i], alone[mirror[i]], 0.03 * most) << grid().candidates[i].name;
}

TEST(BoundPlacement, RefusesNobodyAndTheLopsided) {
  const auto none = bound_placement({}, MatrixXd(0, 53), even_gram(), {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::bad_usage);
  const std::vector<SensorCandidate> one = {
      {.name = "cheek", .side = 'L', .position_m = Vec3(0.0347, -0.0190, 0.0999)}};
  const auto lopsided = bound_placement(one, drawn_slopes(3, 4), even_gram(), {});
  ASSERT_FALSE(lopsided);
  EXPECT_EQ(lopsided.error().code, ErrorCode::bad_usage);
  EXPECT_TRUE(bound_placement(one, drawn_slopes(3, 4), even_gram(), {.one_sided = true}));
}

TEST(PlacementGram, IsTheMeanSquareOfTheSkin) {
  const face::Face& face = builtin_face::default_builtin();
  const MatrixXd& gram = grid().gram;
  // One shape alone: the mean of its squared displacements over the region.
  const std::size_t jaw = face::shape("jawOpen");
  const face::Region* skin = face.region("skin");
  ASSERT_NE(skin, nullptr);
  double sum = 0;
  for (std::size_t i = 0; i < face.shapes[jaw].vertex.size(); ++i)
    if (std::ranges::binary_search(skin->vertex, face.shapes[jaw].vertex[i]))
      sum += 1e6 * face.shapes[jaw].delta_m[i].cast<double>().squaredNorm();
  const auto k = static_cast<Eigen::Index>(jaw);
  EXPECT_NEAR(gram(k, k), sum / static_cast<double>(skin->vertex.size()), 1e-9 * gram(k, k));
  EXPECT_EQ(gram, gram.transpose());
  for (const PlacementObjective objective : {PlacementObjective::mse, PlacementObjective::groups})
    EXPECT_NEAR(placement_gram(face, objective).trace(), 1, 1e-12);
}

}  // namespace
}  // namespace mien::lab::placement_bound_test
