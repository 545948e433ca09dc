#include "mien/core/one_euro.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "mien/core/random.h"

namespace mien::one_euro_test {
namespace {

DeviceTime at(double seconds) {
  return DeviceTime(from_seconds(seconds));
}

struct Row {
  double time_s;
  double noisy;
  double filtered;
};
// The first rows of groundTruth.csv of github.com/casiez/OneEuroFilter (commit 56126d8; copyright Inria,
// BSD 3-clause), with which the authors hold every language's implementation to one answer: 120 Hz, minimum
// cutoff 1 Hz, beta 0.1, cutoff of the derivative 1 Hz. Six digits are published.
constexpr std::array<Row, 50> kGroundTruth = {{
    {0, -0.0385099, -0.0385099},
    {0.00833333, -0.0280664, -0.0379872},
    {0.0166667, 0.048622, -0.0334427},
    {0.025, 0.111498, -0.0252696},
    {0.0333333, 0.053026, -0.0207099},
    {0.0416667, 0.120548, -0.0119912},
    {0.05, 0.00972308, -0.0106507},
    {0.0583333, 0.074193, -0.00526521},
    {0.0666667, -0.0236801, -0.00641239},
    {0.075, 0.0462396, -0.00308863},
    {0.0833333, 0.0892027, 0.00291027},
    {0.0916667, 0.158329, 0.0135545},
    {0.1, 0.0423086, 0.01552},
    {0.108333, 0.0887203, 0.0206024},
    {0.116667, 0.039102, 0.0218784},
    {0.125, 0.140277, 0.030313},
    {0.133333, 0.156938, 0.0396331},
    {0.141667, 0.0961089, 0.0438101},
    {0.15, 0.216881, 0.0572083},
    {0.158333, 0.067538, 0.057997},
    {0.166667, 0.0737634, 0.0591871},
    {0.175, 0.0989231, 0.0621793},
    {0.183333, 0.148209, 0.0687489},
    {0.191667, 0.0959887, 0.0708137},
    {0.2, 0.225627, 0.0829925},
    {0.208333, 0.292078, 0.100305},
    {0.216667, 0.185221, 0.107391},
    {0.225, 0.133595, 0.109553},
    {0.233333, 0.216387, 0.118501},
    {0.241667, 0.316189, 0.135759},
    {0.25, 0.156782, 0.137568},
    {0.258333, 0.164811, 0.139884},
    {0.266667, 0.167903, 0.142239},
    {0.275, 0.273214, 0.153484},
    {0.283333, 0.305514, 0.166876},
    {0.291667, 0.342528, 0.182828},
    {0.3, 0.334796, 0.196929},
    {0.308333, 0.210729, 0.198186},
    {0.316667, 0.401551, 0.217377},
    {0.325, 0.267666, 0.222081},
    {0.333333, 0.365411, 0.235717},
    {0.341667, 0.429558, 0.254702},
    {0.35, 0.400613, 0.269202},
    {0.358333, 0.377235, 0.279981},
    {0.366667, 0.290475, 0.281006},
    {0.375, 0.3709, 0.289789},
    {0.383333, 0.343945, 0.295032},
    {0.391667, 0.409876, 0.306231},
    {0.4, 0.449394, 0.320391},
    {0.408333, 0.408817, 0.32913},
}};
constexpr OneEuroSettings kGroundTruthSettings{.min_cutoff_hz = 1, .beta = 0.1, .derivative_cutoff_hz = 1};

TEST(OneEuro, AgreesWithTheAuthorsGroundTruth) {
  OneEuro filter(kGroundTruthSettings);
  for (const Row& row : kGroundTruth)
    EXPECT_NEAR(filter.filter(at(row.time_s), row.noisy), row.filtered, 4e-6) << row.time_s;
}

TEST(OneEuro, ShareIsThatOfAFirstOrderLowPass) {
  EXPECT_DOUBLE_EQ(low_pass_share(1, 1 / (2 * std::numbers::pi)), 0.5);
  EXPECT_EQ(low_pass_share(0, 1), 0);
  EXPECT_EQ(low_pass_share(-1, 1), 0);
  EXPECT_EQ(low_pass_share(1, 0), 0);
  EXPECT_EQ(low_pass_share(std::numeric_limits<double>::quiet_NaN(), 1), 0);
  EXPECT_LT(low_pass_share(1000, 1000), 1);
}

TEST(OneEuro, FollowsAClosedFormWithoutBeta) {
  // After n equal steps to 1 the rest of the way is (1 - share)^n.
  OneEuro filter({.min_cutoff_hz = 3});
  filter.filter(at(0), 0);
  const double share = low_pass_share(3, 0.01);
  for (int i = 1; i <= 50; ++i)
    EXPECT_NEAR(filter.filter(at(0.01 * i), 1), 1 - std::pow(1 - share, i), 1e-12);
}

TEST(OneEuro, SettlesOnARampAtTheDelayItNames) {
  const double cutoff = 2;
  OneEuro filter({.min_cutoff_hz = cutoff});
  double out = 0;
  for (int i = 0; i <= 4000; ++i) out = filter.filter(at(i / 1000.0), 0.3 * i / 1000.0);
  EXPECT_NEAR((0.3 * 4 - out) / 0.3, 1 / (2 * std::numbers::pi * cutoff), 1e-3);
}

TEST(OneEuro, BetaTakesTheDelayOutOfQuickMovement) {
  OneEuro slow({.min_cutoff_hz = 1, .beta = 0});
  OneEuro quick({.min_cutoff_hz = 1, .beta = 5});
  for (int i = 0; i <= 60; ++i) {
    slow.filter(at(i / 60.0), i / 60.0);
    quick.filter(at(i / 60.0), i / 60.0);
  }
  EXPECT_LT(1 - quick.value(), 0.4 * (1 - slow.value()));
}

TEST(OneEuro, NeedsNothingForAGap) {
  OneEuro filter({.min_cutoff_hz = 1});
  filter.filter(at(0), 0);
  EXPECT_GT(filter.filter(at(20), 1), 0.99);
}

TEST(OneEuro, IsNotMovedByWhatIsNoNumberOrNoLater) {
  OneEuro filter({.min_cutoff_hz = 1, .beta = 1});
  EXPECT_EQ(filter.filter(at(0), std::nan("")), 0);
  EXPECT_EQ(filter.filter(at(0), 0.25), 0.25);
  const double before = filter.filter(at(0.1), 0.5);
  EXPECT_EQ(filter.filter(at(0.2), std::nan("")), before);
  EXPECT_EQ(filter.filter(at(0.2), std::numeric_limits<double>::infinity()), before);
  EXPECT_EQ(filter.filter(at(0.1), 1), before);  // No time has passed.
  EXPECT_EQ(filter.filter(at(0.05), 1), before);
  OneEuro clean({.min_cutoff_hz = 1, .beta = 1});
  clean.filter(at(0), 0.25);
  clean.filter(at(0.1), 0.5);
  EXPECT_EQ(filter.filter(at(0.3), 0.7), clean.filter(at(0.3), 0.7));
}

TEST(OneEuro, BeginsAnewAfterAReset) {
  OneEuro filter({.min_cutoff_hz = 1});
  filter.filter(at(5), 1);
  filter.reset();
  EXPECT_EQ(filter.value(), 0);
  EXPECT_EQ(filter.filter(at(1), 0.5), 0.5);
}

TEST(OneEuro, TakesNewSettingsWithoutAJump) {
  OneEuro filter({.min_cutoff_hz = 1});
  filter.filter(at(0), 0);
  const double before = filter.filter(at(0.1), 1);
  filter.set({.min_cutoff_hz = 10});
  EXPECT_EQ(filter.value(), before);
}

TEST(OneEuroRotation, DoesAboutOneAxisWhatTheScalarDoes) {
  const OneEuroSettings settings{.min_cutoff_hz = 1.5, .beta = 2};
  OneEuro scalar(settings);
  OneEuroRotation rotation(settings);
  Random random(4);
  const Vec3 axis = random.direction();
  for (int i = 0; i < 300; ++i) {
    const double angle = 0.8 * std::sin(i / 20.0) + random.normal(0, 0.02);
    const double expected = scalar.filter(at(i / 60.0), angle);
    const Quat out = rotation.filter(at(i / 60.0), exp_rotation(axis * angle));
    ASSERT_LT(angle_between(out, exp_rotation(axis * expected)), 1e-7) << i;
  }
}

TEST(OneEuroRotation, TakesEitherSignAndRefusesWhatIsNoRotation) {
  OneEuroRotation filter({.min_cutoff_hz = 2});
  const Quat q = exp_rotation({0.1, 0.2, -0.3});
  filter.filter(at(0), q);
  EXPECT_LT(angle_between(filter.filter(at(0.1), Quat(-q.w(), -q.x(), -q.y(), -q.z())), q), 1e-9);
  const Quat before = filter.value();
  EXPECT_EQ(filter.filter(at(0.2), Quat(std::nan(""), 0, 0, 0)).coeffs(), before.coeffs());
  EXPECT_EQ(filter.filter(at(0.3), Quat(0, 0, 0, 0)).coeffs(), before.coeffs());
  EXPECT_GE(filter.value().w(), 0);
}

}  // namespace
}  // namespace mien::one_euro_test
