#include "mien/model/skin_map.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "mien/core/random.h"
#include "mien/core/rotation.h"

namespace mien::model::skin_map_test {
namespace {

constexpr std::size_t kSensors = 3, kShapes = 4;

/// Three sensors that feel four shapes, each by up to a third of a radian.
struct Worn {
  Eigen::MatrixXd standard, wearer;
  Skin skin;
  std::vector<float> mean = std::vector<float>(kShapes, 0.1F);

  explicit Worn(std::uint64_t seed, double change = 0.4) {
    Random random(seed);
    standard = Eigen::MatrixXd::NullaryExpr(3 * kSensors, kShapes, [&] { return 0.2 * random.normal(); });
    wearer = standard + Eigen::MatrixXd::NullaryExpr(3 * kSensors, kShapes,
                                                     [&] { return change * 0.2 * random.normal(); });
    for (Eigen::Index row = 0; row < standard.rows(); ++row)
      for (Eigen::Index k = 0; k < standard.cols(); ++k) {
        skin.standard.push_back(static_cast<float>(standard(row, k)));
        skin.wearer.push_back(static_cast<float>(wearer(row, k)));
      }
    skin.covariance.assign(kShapes * kShapes, 0.0F);
    for (std::size_t k = 0; k < kShapes; ++k) skin.covariance[k * kShapes + k] = 0.04F;
  }
};

std::vector<float> values_of(const Eigen::VectorXd& turn) {
  std::vector<float> values;
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(kSensors); ++s) {
    const Quat q = canonical(exp_rotation(Vec3(turn.segment<3>(3 * s))));
    for (const double v : {1.0, 2.0, 3.0, q.w(), q.x(), q.y(), q.z()})
      values.push_back(static_cast<float>(v));
  }
  return values;
}

double distance(const std::vector<float>& values, const Eigen::VectorXd& turn, std::size_t sensor) {
  const float* q = values.data() + 7 * sensor + 3;
  const Vec3 is = log_rotation(Quat(q[0], q[1], q[2], q[3]));
  return (is - Vec3(turn.segment<3>(3 * static_cast<Eigen::Index>(sensor)))).norm();
}

const std::vector<std::uint8_t> kAll(2 * kSensors, 1);

TEST(SkinMap, GivesWhatTheStandardSkinWouldSay) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Worn worn(seed);
    SkinMap map(worn.skin, worn.mean);
    const Eigen::VectorXd weights = Eigen::Vector4d(0.4, 0.1, 0.0, 0.3);
    std::vector<float> values = values_of(worn.wearer * weights);
    map.apply(values, kAll);
    double before = 0, after = 0;
    for (std::size_t s = 0; s < kSensors; ++s) {
      before += distance(values_of(worn.wearer * weights), worn.standard * weights, s);
      after += distance(values, worn.standard * weights, s);
    }
    EXPECT_LT(after, 0.35 * before) << seed;
    EXPECT_EQ(values[0], 1.0F) << "accelerations stay";
  }
}

TEST(SkinMap, ChangesNothingForTheStandardSkin) {
  const Worn worn(3, 0);
  SkinMap map(worn.skin, worn.mean);
  const std::vector<float> before = values_of(worn.wearer * Eigen::Vector4d(0.4, 0.1, 0.0, 0.3));
  std::vector<float> after = before;
  map.apply(after, kAll);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-6) << i;
}

TEST(SkinMap, AMissingSensorSaysNothingAndIsLeftAlone) {
  const Worn worn(2);
  SkinMap map(worn.skin, worn.mean);
  std::vector<std::uint8_t> present = kAll;
  present[1] = 0;
  const Eigen::VectorXd turn = worn.wearer * Eigen::Vector4d(0.4, 0.1, 0.0, 0.3);
  std::vector<float> one = values_of(turn), other = values_of(turn);
  std::fill_n(other.begin() + 7, 7, 0.5F);
  map.apply(one, present);
  const std::vector<float> left(other.begin() + 7, other.begin() + 14);
  map.apply(other, present);
  for (const std::size_t s : {0U, 2U})
    for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(one[7 * s + i], other[7 * s + i]);
  EXPECT_TRUE(std::equal(left.begin(), left.end(), other.begin() + 7));

  // It is heard again as if it had never been away.
  std::vector<float> back = values_of(turn), fresh = back;
  map.apply(back, kAll);
  SkinMap(worn.skin, worn.mean).apply(fresh, kAll);
  EXPECT_EQ(back, fresh);
}

}  // namespace
}  // namespace mien::model::skin_map_test
