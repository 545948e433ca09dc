#include "mien/eyewear/linearise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace mien::eyewear::linearise_test {
namespace {

/// Light that rises to 3 mm and falls as 1 / (d + 2 mm)^2 beyond.
double light_at(double mm) {
  return mm < 3 ? 0.7 * mm / 3 : 0.7 * 25 / ((mm + 2) * (mm + 2));
}

std::vector<BenchReading> bench() {
  std::vector<BenchReading> readings;
  for (double mm = 1; mm <= 30; mm += 0.5) readings.push_back({1e-3 * mm, light_at(mm)});
  return readings;
}

TEST(Linearisation, TellsDistancesBeyondThePeak) {
  const auto line = Linearisation::fit(bench());
  ASSERT_TRUE(line) << line.error().message();
  for (double mm = 3; mm <= 30; mm += 0.25)
    EXPECT_NEAR(line->distance_m(light_at(mm)), 1e-3 * mm, 1e-4) << mm;
}

TEST(Linearisation, HoldsWhatItCannotTell) {
  const auto line = Linearisation::fit(bench());
  ASSERT_TRUE(line);
  EXPECT_DOUBLE_EQ(line->distance_m(10), line->distance_m(line->brightest()));
  EXPECT_DOUBLE_EQ(line->distance_m(0), line->distance_m(line->dimmest()));
  EXPECT_DOUBLE_EQ(line->distance_m(-1), line->distance_m(line->dimmest()));
  EXPECT_NEAR(line->distance_m(10), 0.003, 2e-4);
}

TEST(Linearisation, IsMonotoneWhereItHolds) {
  const auto line = Linearisation::fit(bench());
  ASSERT_TRUE(line);
  double last = std::numeric_limits<double>::infinity();
  for (double light = line->dimmest(); light <= line->brightest(); light *= 1.02) {
    EXPECT_LT(line->distance_m(light), last);
    last = line->distance_m(light);
  }
}

TEST(Linearisation, RefusesBenchesThatSayTooLittle) {
  std::vector<BenchReading> readings = bench();
  EXPECT_EQ(Linearisation::fit(readings, 0).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(Linearisation::fit(readings, 9).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(Linearisation::fit(std::span(readings).first(8)).error().code, ErrorCode::bad_usage);
  EXPECT_FALSE(Linearisation::fit({}));
  for (const double wrong : {0.0, -1.0, std::nan("")}) {
    std::vector<BenchReading> spoilt = readings;
    spoilt[9].light = wrong;
    EXPECT_EQ(Linearisation::fit(spoilt).error().code, ErrorCode::out_of_range);
    spoilt = readings;
    spoilt[9].distance_m = wrong;
    EXPECT_EQ(Linearisation::fit(spoilt).error().code, ErrorCode::out_of_range);
  }
}

}  // namespace
}  // namespace mien::eyewear::linearise_test
