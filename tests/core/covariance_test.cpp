#include "mien/core/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "mien/core/random.h"

namespace mien::covariance_test {
namespace {

template <int N, int M>
using Matrix = Eigen::Matrix<double, N, M>;

template <int N, int M>
Matrix<N, M> gain_of(const Matrix<N, N>& covariance, const Matrix<M, N>& observation,
                     const Matrix<M, M>& noise) {
  const Matrix<N, M> spread = covariance * observation.transpose();
  return spread * Matrix<M, M>(observation * spread + noise).inverse();
}

/// The least eigenvalue as a share of the largest.
template <int N>
double least_share(const Matrix<N, N>& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix<N, N>> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() / solver.eigenvalues().maxCoeff();
}

template <int N>
Matrix<N, N> correlations(const Matrix<N, N>& covariance) {
  const Matrix<N, 1> scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

/// A filter that runs for hours: states in units so unlike that their variances are 1e-10 to 1e2, directions
/// and noise that change with every update, and hardly any process noise.
template <int N, int M>
void expect_sound_after_a_million_updates() {
  constexpr int kUpdates = 1'000'000, kJudgedEvery = 1'000;
  constexpr double kForgotten = 1e-9;  // Share of the first variances that an update's time adds.
  constexpr double kLeastShare = -1e-12;
  Random random(1);
  Matrix<N, 1> first;
  for (int i = 0; i < N; ++i) first[i] = std::pow(10.0, -10 + 12.0 * i / (N - 1));
  Matrix<N, N> covariance = first.asDiagonal();
  for (int update = 1; update <= kUpdates; ++update) {
    covariance.diagonal() += kForgotten * first;
    Matrix<M, N> observation;
    Matrix<M, M> noise = Matrix<M, M>::Zero();
    for (int row = 0; row < M; ++row) {
      for (int i = 0; i < N; ++i) observation(row, i) = random.uniform(-1, 1) / std::sqrt(first[i]);
      noise(row, row) = std::pow(10.0, -static_cast<double>(random.below(5)));
    }
    update_covariance<N, M>(covariance, observation, gain_of<N, M>(covariance, observation, noise), noise);
    if (update % kJudgedEvery != 0) continue;
    ASSERT_TRUE(is_covariance(covariance)) << "after " << update << " updates:\n" << covariance;
    ASSERT_GT(covariance.diagonal().minCoeff(), 0) << "after " << update << " updates:\n" << covariance;
    ASSERT_GE(least_share<N>(covariance), kLeastShare) << "after " << update << " updates:\n" << covariance;
    ASSERT_GE(least_share<N>(correlations<N>(covariance)), kLeastShare) << "after " << update << " updates";
    ASSERT_TRUE((covariance.diagonal().array() <= (1 + 1e-6) * first.array()).all())
        << "after " << update << " updates:\n"
        << covariance;
  }
}

TEST(UpdateCovariance, StaysACovarianceForAMillionUpdatesOfThreeNumbers) {
  expect_sound_after_a_million_updates<8, 3>();
}

TEST(UpdateCovariance, StaysACovarianceForAMillionUpdatesOfOneNumber) {
  expect_sound_after_a_million_updates<8, 1>();
}

TEST(UpdateCovariance, StaysACovarianceForAMillionUpdatesOfTheWholeState) {
  expect_sound_after_a_million_updates<3, 3>();
}

TEST(UpdateCovariance, IsWhatInformationAddsUpTo) {
  Random random(2);
  const auto drawn = [&](auto& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = random.normal();
  };
  for (int draw = 0; draw < 100; ++draw) {
    Matrix<8, 8> root;
    Matrix<3, 3> noise_root;
    Matrix<3, 8> observation;
    drawn(root);
    drawn(noise_root);
    drawn(observation);
    const Matrix<8, 8> before = root * root.transpose() + Matrix<8, 8>::Identity();
    const Matrix<3, 3> noise = noise_root * noise_root.transpose() + Matrix<3, 3>::Identity();
    const Matrix<8, 8> information =
        before.inverse() + observation.transpose() * noise.inverse() * observation;
    const Matrix<8, 8> expected = information.inverse();
    Matrix<8, 8> covariance = before;
    update_covariance<8, 3>(covariance, observation, gain_of<8, 3>(before, observation, noise), noise);
    EXPECT_LT((covariance - expected).norm(), 1e-11 * expected.norm());
    EXPECT_TRUE(is_covariance(covariance));
  }
}

TEST(UpdateCovariance, OfAGainThatIsNotTheBestIsTheErrorsOwn) {
  // Half of the difference is taken over: a quarter of either variance is left.
  Matrix<1, 1> variance(4.0);
  update_covariance<1, 1>(variance, Matrix<1, 1>(1.0), Matrix<1, 1>(0.5), Matrix<1, 1>(12.0));
  EXPECT_EQ(variance(0, 0), 0.25 * 4 + 0.25 * 12);
}

TEST(UpdateCovariance, IsSymmetricToTheBitWhateverItBeganWith) {
  Random random(3);
  Matrix<8, 8> root;
  for (double& x : root.reshaped()) x = random.normal();
  Matrix<8, 8> covariance = root * root.transpose();
  covariance(2, 5) += 1e-9;
  const Matrix<1, 8> observation = Matrix<1, 8>::Unit(2);
  update_covariance<8, 1>(covariance, observation, gain_of<8, 1>(covariance, observation, Matrix<1, 1>(1.0)),
                          Matrix<1, 1>(1.0));
  EXPECT_TRUE(is_covariance(covariance));
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

Matrix<3, 3> sound() {
  Matrix<3, 3> covariance;
  covariance << 4, 1, -2,  //
      1, 9, 0.5,           //
      -2, 0.5, 1;
  return covariance;
}

TEST(IsCovariance, TakesWhatCanBeOne) {
  EXPECT_TRUE(is_covariance(sound()));
  EXPECT_TRUE(is_covariance(Matrix<3, 3>(Matrix<3, 3>::Zero())));  // All is known.
  EXPECT_TRUE(is_covariance(Eigen::MatrixXd(1e-300 * Eigen::MatrixXd::Identity(5, 5))));
  EXPECT_TRUE(is_covariance(Eigen::MatrixXd()));
}

TEST(IsCovariance, RefusesOneBitOfAsymmetry) {
  Matrix<3, 3> covariance = sound();
  covariance(0, 1) = std::nextafter(covariance(0, 1), kInfinite);
  EXPECT_FALSE(is_covariance(covariance));
  covariance(1, 0) = covariance(0, 1);
  EXPECT_TRUE(is_covariance(covariance));
}

TEST(IsCovariance, RefusesAVarianceBelowZero) {
  for (const double variance : {-1.0, -std::numeric_limits<double>::denorm_min()}) {
    Matrix<3, 3> covariance = Matrix<3, 3>::Identity();
    covariance(2, 2) = variance;
    EXPECT_FALSE(is_covariance(covariance)) << variance;
  }
}

TEST(IsCovariance, RefusesWhatIsNotFinite) {
  for (const double value : {kNoNumber, kInfinite, -kInfinite})
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) {
        Matrix<3, 3> covariance = sound();
        covariance(i, j) = covariance(j, i) = value;
        EXPECT_FALSE(is_covariance(covariance)) << value << " at " << i << ", " << j;
      }
}

TEST(IsCovariance, RefusesACorrelationBeyondOne) {
  for (const double sign : {-1.0, 1.0}) {
    Matrix<3, 3> covariance = sound();
    covariance(0, 1) = covariance(1, 0) = sign * 6;  // One, of variances 4 and 9.
    EXPECT_TRUE(is_covariance(covariance));
    covariance(0, 1) = covariance(1, 0) = sign * 6.000001;
    EXPECT_FALSE(is_covariance(covariance));
  }
  Matrix<3, 3> known = sound();
  known(2, 2) = 0;  // What is known for certain goes with nothing.
  EXPECT_FALSE(is_covariance(known));
}

}  // namespace
}  // namespace mien::covariance_test
