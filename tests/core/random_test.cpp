#include "mien/core/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace mien::random_test {
namespace {

// splitmix64 from 0 gives E220A8397B1DCDAF, 6E789E6AA1B965F4, 06C45D188009454F, F88BB8A8724C81EC (its
// authors' own test values), and xoshiro256++ on that state the numbers below: computed by hand from the
// published definition, rotl(s0 + s3, 23) + s0.
TEST(Random, KnownVectors) {
  Random random(0);
  const auto& words = random.state().words;
  EXPECT_EQ(words[0], 0xE220A8397B1DCDAFU);
  EXPECT_EQ(words[1], 0x6E789E6AA1B965F4U);
  EXPECT_EQ(words[2], 0x06C45D188009454FU);
  EXPECT_EQ(words[3], 0xF88BB8A8724C81ECU);
  EXPECT_EQ(random.bits(), 0x53175D61490B23DFU);
  EXPECT_EQ(random.bits(), 0x61DA6F3DC380D507U);
  EXPECT_EQ(random.bits(), 0x5C0FDF91EC9A7BFCU);
}

TEST(Random, SameSeedSameNumbers) {
  Random a(42);
  Random b(42);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(a.bits(), b.bits());
    EXPECT_EQ(a.normal(), b.normal());
    EXPECT_EQ(a.rotation().coeffs(), b.rotation().coeffs());
  }
}

TEST(Random, ForksAreIndependentOfDrawing) {
  Random drawn(9);
  for (int i = 0; i < 10; ++i) drawn.normal();
  EXPECT_EQ(drawn.fork("blink").bits(), Random(9).fork("blink").bits());
}

TEST(Random, ForksDifferByNameIndexAndSeed) {
  std::set<std::uint64_t> first;
  int count = 0;
  for (const std::uint64_t seed : {0U, 1U, 2U})
    for (const char* name : {"", "a", "b", "blink", "imu"})
      for (const std::uint64_t index : {0U, 1U, 2U, 1000U}) {
        first.insert(Random(seed).fork(name, index).bits());
        ++count;
      }
  EXPECT_EQ(static_cast<int>(first.size()), count);
}

TEST(Random, StateResumesBitForBit) {
  Random random(3);
  random.normal();  // Leaves the second of a pair in the state.
  const Random::State saved = random.state();
  std::vector<double> rest;
  for (int i = 0; i < 20; ++i) rest.push_back(random.normal());
  Random resumed(0);
  resumed.restore(saved);
  for (const double value : rest) EXPECT_EQ(resumed.normal(), value);
}

TEST(Random, UniformStaysInItsRange) {
  Random random(1);
  double sum = 0;
  double squares = 0;
  constexpr int kCount = 100'000;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.005);
  EXPECT_NEAR(squares / kCount, 1.0 / 3.0, 0.005);
}

TEST(Random, BelowIsEven) {
  Random random(5);
  std::array<int, 7> seen{};
  constexpr int kCount = 70'000;
  for (int i = 0; i < kCount; ++i) ++seen[random.below(7)];
  for (const int n : seen) EXPECT_NEAR(n, kCount / 7, 400);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.below(1), 0U);
  // Close to the top of the range, where rejection matters.
  for (int i = 0; i < 100; ++i)
    EXPECT_LT(random.below((std::uint64_t{1} << 63U) + 1), (std::uint64_t{1} << 63U) + 1);
}

TEST(Random, DistributionsHaveTheirMoments) {
  Random random(11);
  constexpr int kCount = 200'000;
  double mean = 0;
  double variance = 0;
  double fourth = 0;
  double exponential = 0;
  double log_normal = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    mean += x;
    variance += x * x;
    fourth += x * x * x * x;
    exponential += random.exponential(2.5);
    log_normal += std::log(random.log_normal(0.3)) * std::log(random.log_normal(0.3));
  }
  EXPECT_NEAR(mean / kCount, 0, 0.01);
  EXPECT_NEAR(variance / kCount, 1, 0.02);
  EXPECT_NEAR(fourth / kCount, 3, 0.1);
  EXPECT_NEAR(exponential / kCount, 2.5, 0.03);
  EXPECT_NEAR(log_normal / kCount, 0, 0.01);  // Two draws are independent.
  EXPECT_NEAR(random.normal(5.0, 0.0), 5.0, 0.0);
}

TEST(Random, DirectionsCoverTheSphereEvenly) {
  Random random(13);
  Vec3 mean = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  constexpr int kCount = 50'000;
  for (int i = 0; i < kCount; ++i) {
    const Vec3 d = random.direction();
    ASSERT_NEAR(d.norm(), 1, 1e-12);
    mean += d / kCount;
    second += d * d.transpose() / kCount;
  }
  EXPECT_LT(mean.norm(), 0.02);
  EXPECT_LT((second - Mat3::Identity() / 3).norm(), 0.02);
}

// An even spread over all orientations has an angle distribution with density (1 - cos a) / pi: mean pi/2 +
// 2/pi.
TEST(Random, RotationsAreEven) {
  Random random(17);
  double angle = 0;
  constexpr int kCount = 50'000;
  for (int i = 0; i < kCount; ++i) {
    const Quat q = random.rotation();
    ASSERT_NEAR(q.norm(), 1, 1e-12);
    ASSERT_GE(q.w(), 0);
    angle += angle_between(Quat::Identity(), q) / kCount;
  }
  EXPECT_NEAR(angle, M_PI / 2 + 2 / M_PI, 0.01);
}

// Bits that every compiler must agree on: the order of the four draws inside rotation() is part of the
// contract.
TEST(Random, RotationDrawsInOrder) {
  Random whole(23);
  Random parts(23);
  const Quat q = whole.rotation();
  const double w = parts.normal();
  const double x = parts.normal();
  const double y = parts.normal();
  const double z = parts.normal();
  EXPECT_EQ(q.coeffs(), canonical(Quat(w, x, y, z)).coeffs());
}

}  // namespace
}  // namespace mien::random_test
