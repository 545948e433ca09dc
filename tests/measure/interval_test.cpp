#include "mien/measure/interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "mien/core/random.h"

namespace mien::measure::interval_test {
namespace {

TEST(StudentsT, IsAsTablesHaveIt) {
  // NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.2.
  for (const auto& [degrees, quantile] :
       {std::pair(1.0, 12.706), std::pair(2.0, 4.303), std::pair(5.0, 2.571), std::pair(10.0, 2.228),
        std::pair(15.0, 2.131), std::pair(30.0, 2.042), std::pair(100.0, 1.984), std::pair(1e9, 1.960)})
    EXPECT_NEAR(student_95(degrees), quantile, 0.001 * quantile) << degrees;
  EXPECT_GT(student_95(2), student_95(2.5));
  EXPECT_GT(student_95(2.5), student_95(3));
}

TEST(Intervals, OfPeopleAloneAreStudents) {
  // Mean 3, standard deviation sqrt(2.5), five people: 4 degrees of freedom.
  const Interval of = mean_interval({{1, 2, 3, 4, 5}});
  const double half = 2.776 * std::sqrt(2.5 / 5);
  EXPECT_DOUBLE_EQ(of.mean, 3);
  EXPECT_NEAR(of.low, 3 - half, 0.01);
  EXPECT_NEAR(of.high, 3 + half, 0.01);
}

TEST(Intervals, OfOneFigureIsTheFigure) {
  const Interval of = mean_interval({{4}});
  EXPECT_EQ(of.mean, 4);
  EXPECT_EQ(of.low, 4);
  EXPECT_EQ(of.high, 4);
}

TEST(Intervals, SeedsThatDisagreeWidenThem) {
  const Interval agreed = mean_interval({{1, 2, 3, 4}, {1, 2, 3, 4}, {1, 2, 3, 4}});
  const Interval torn = mean_interval({{-1, 0, 1, 2}, {1, 2, 3, 4}, {3, 4, 5, 6}});
  EXPECT_EQ(agreed.mean, torn.mean);
  EXPECT_GT(torn.high - torn.low, agreed.high - agreed.low);
}

/// How people, seeds and each pair of them vary.
struct Variation {
  double person, seed, both;
};

struct IntervalCoverage : public ::testing::TestWithParam<Variation> {};

TEST_P(IntervalCoverage, IsWhatTheySay) {
  Random random(5);
  int held = 0;
  double widths = 0;
  constexpr int kTrials = 4000, kSeeds = 3, kPeople = 12;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> person(kPeople);
    for (double& p : person) p = random.normal(0, GetParam().person);
    SeedFigures figures(kSeeds);
    for (std::vector<double>& of_seed : figures) {
      const double seed = random.normal(0, GetParam().seed);
      for (const double p : person) of_seed.push_back(7 + seed + p + random.normal(0, GetParam().both));
    }
    const Interval of = mean_interval(figures);
    widths += of.half() / kTrials;
    if (of.low <= 7 && 7 <= of.high) ++held;
  }
  const double coverage = static_cast<double>(held) / kTrials;
  const double sigma =
      std::sqrt(std::pow(GetParam().person, 2) / kPeople + std::pow(GetParam().seed, 2) / kSeeds +
                std::pow(GetParam().both, 2) / (kPeople * kSeeds));
  std::printf("coverage %.3f, half width %.2f sigma\n", coverage, widths / sigma);
  // Where people and seeds alike vary by no more than their pairs, intervals are a little wide.
  EXPECT_GT(coverage, 0.93);
  EXPECT_LT(coverage, 0.99);
}

INSTANTIATE_TEST_SUITE_P(Intervals, IntervalCoverage,
                         ::testing::Values(Variation{1, 0, 0}, Variation{1, 0.3, 0}, Variation{1, 0.3, 0.5},
                                           Variation{0.3, 0.3, 1}, Variation{0, 0, 1}, Variation{0, 1, 0.3}));

TEST(Changes, ArePairedByPersonAndSeed) {
  // People differ by far more than the methods do: unpaired, nothing could be told.
  const SeedFigures base = {{1, 10, 5}, {1.1, 10.1, 5.1}};
  SeedFigures worse = base;
  for (auto& seed : worse)
    for (double& figure : seed) figure *= 1.1;
  const Interval change = change_interval(worse, base);
  EXPECT_NEAR(change.mean, 0.1, 1e-12);
  EXPECT_NEAR(change.low, change.high, 1e-9);
}

TEST(Changes, HoldTheChangeAsOftenAsTheySay) {
  Random random(6);
  int held = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    SeedFigures base(3), figures(3);
    std::vector<double> person(12);
    for (double& p : person) p = random.uniform(0.5, 2);
    for (int s = 0; s < 3; ++s)
      for (const double p : person) {
        base[static_cast<std::size_t>(s)].push_back(p * (1 + 0.05 * random.normal()));
        figures[static_cast<std::size_t>(s)].push_back(1.3 * p * (1 + 0.1 * random.normal()));
      }
    const Interval change = change_interval(figures, base);
    if (change.low <= 0.3 && 0.3 <= change.high) ++held;
  }
  EXPECT_NEAR(static_cast<double>(held) / kTrials, 0.95, 0.03);
}

}  // namespace
}  // namespace mien::measure::interval_test
