#include "mien/eyewear/marker_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::eyewear::marker_model_test {
namespace {

Eigen::MatrixXd drawn(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd out(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index c = 0; c < columns; ++c) out(i, c) = random.normal();
  return out;
}

/// Nine numbers that four sensors tell exactly.
struct Linear {
  Eigen::MatrixXd sensors = drawn(100, 4, 1);
  Eigen::MatrixXd relation = drawn(4, 9, 2);
  Eigen::MatrixXd markers = (sensors * relation).rowwise() + Eigen::RowVectorXd::LinSpaced(9, 1, 9);
};

TEST(MarkerModel, FindsALinearRelation) {
  const Linear linear;
  const auto model = MarkerModel::fit(linear.sensors, linear.markers);
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->sensors(), 4);
  const Eigen::MatrixXd unseen = drawn(5, 4, 3);
  for (Eigen::Index i = 0; i < unseen.rows(); ++i) {
    const Eigen::VectorXd expected =
        (unseen.row(i) * linear.relation).transpose() + Eigen::VectorXd::LinSpaced(9, 1, 9);
    EXPECT_LT((model->markers(unseen.row(i).transpose()) - expected).norm(), 1e-9);
  }
}

TEST(MarkerModel, TakesAsManyComponentsAsAsked) {
  const Linear linear;  // Four directions hold everything.
  EXPECT_EQ(MarkerModel::fit(linear.sensors, linear.markers, {.components = 2})->components(), 2);
  EXPECT_LT(MarkerModel::fit(linear.sensors, linear.markers, {.components = 2})->share(), 1);
  const auto whole = MarkerModel::fit(linear.sensors, linear.markers, {.share = 0.999999});
  EXPECT_EQ(whole->components(), 4);
  EXPECT_NEAR(whole->share(), 1, 1e-6);
  EXPECT_EQ(MarkerModel::fit(linear.sensors, linear.markers, {.share = 1e-6})->components(), 1);
  const Eigen::MatrixXd basis = whole->basis();
  EXPECT_LT((basis.transpose() * basis - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-9);
}

TEST(MarkerModel, LivesWithSensorsThatSayNothing) {
  const Linear linear;
  Eigen::MatrixXd sensors(100, 6);
  sensors << linear.sensors, Eigen::VectorXd::Constant(100, 0.7), linear.sensors.col(0);
  const auto model = MarkerModel::fit(sensors, linear.markers);
  ASSERT_TRUE(model);
  for (Eigen::Index i = 0; i < 100; i += 10)
    EXPECT_LT((model->markers(sensors.row(i).transpose()) - linear.markers.row(i).transpose()).norm(), 1e-8);
}

TEST(MarkerModel, RefusesWhatItCannotFit) {
  const Linear linear;
  const auto code = [](const Eigen::MatrixXd& sensors, const Eigen::MatrixXd& markers,
                       const MarkerModelSettings& settings = {}) {
    const auto model = MarkerModel::fit(sensors, markers, settings);
    EXPECT_FALSE(model);
    return model.error().code;
  };
  EXPECT_EQ(code(linear.sensors.topRows(50), linear.markers), ErrorCode::mismatch);
  EXPECT_EQ(code(linear.sensors.topRows(5), linear.markers.topRows(5)), ErrorCode::bad_usage);
  EXPECT_EQ(code(linear.sensors, linear.markers, {.components = 0}), ErrorCode::bad_usage);
  EXPECT_EQ(code(linear.sensors, linear.markers, {.share = std::nan("")}), ErrorCode::bad_usage);
  EXPECT_EQ(code(linear.sensors, linear.markers, {.share = 1.5}), ErrorCode::bad_usage);
  Eigen::MatrixXd spoilt = linear.sensors;
  spoilt(3, 1) = std::nan("");
  EXPECT_EQ(code(spoilt, linear.markers), ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::eyewear::marker_model_test
