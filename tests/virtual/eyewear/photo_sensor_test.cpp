#include "mien/virtual/eyewear/photo_sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace mien::virt::photo_sensor_test {
namespace {

TEST(PhotoResponse, PeaksWhereItIsSaidTo) {
  for (const double peak_mm : {1.0, 3.0, 6.0}) {
    const PhotoResponse response(1e-3 * peak_mm, 0.002);
    EXPECT_NEAR(response.at(1e-3 * peak_mm), 1, 1e-12);
    for (double mm = 0.1; mm < 30; mm += 0.1)
      EXPECT_LE(response.at(1e-3 * mm), 1 + 1e-9) << "peak " << peak_mm << ", at " << mm;
    EXPECT_EQ(response.at(0), 0);
    EXPECT_EQ(response.at(-1), 0);
  }
}

TEST(PhotoResponse, FallsWithTheSquareFarOff) {
  const PhotoResponse response(0.003, 0.002);
  EXPECT_NEAR(response.at(0.018) / response.at(0.008), 0.25, 0.01);
}

TEST(PhotoSensor, IsLinearInTheDark) {
  PhotoSensor sensor(EyewearFaults{}, Random(1));
  for (int count = 0; count <= 1023; count += 31)
    EXPECT_NEAR(sensor.read(count / 1023.0, 0.1), count / 1023.0, 1e-12);
}

TEST(PhotoSensor, HasTheConvertersStepsAndEnds) {
  PhotoSensor sensor(EyewearFaults{}, Random(1));
  EXPECT_EQ(sensor.read(1.7, 0), 1);
  EXPECT_EQ(sensor.read(-0.1, 0), 0);
  const double counts = 1023 * sensor.read(0.12345, 0);
  EXPECT_NEAR(counts, std::round(counts), 1e-9);
}

TEST(PhotoSensor, SeesLampsWithTheLedOffToo) {
  EyewearFaults faults;
  faults.ambient = {0.2, 0.2};
  PhotoSensor sensor(faults, Random(1));
  EXPECT_NEAR(sensor.read(0, 0), 0.2, 1e-3);
  EXPECT_NEAR(sensor.read(0.3, 0) - sensor.read(0, 0), 0.3, 2e-3);
}

TEST(PhotoSensor, IsDazzledWhileTheStrobeFlashes) {
  EyewearFaults faults;
  faults.strobe_hz = 100;
  faults.strobe_ms = 1;
  faults.strobe = {0.4, 0.4};
  PhotoSensor sensor(faults, Random(1));
  int dazzled = 0;
  for (int i = 0; i < 1000; ++i)
    if (sensor.read(0.1, i * 0.00137) > 0.3) ++dazzled;
  EXPECT_NEAR(dazzled, 100, 20);
}

TEST(PhotoSensor, PartsDifferAndAreTheSameAgain) {
  EyewearFaults faults;
  faults.part_gain = 0.1;
  faults.noise_counts = 1;
  PhotoSensor one(faults, Random(1));
  PhotoSensor same(faults, Random(1));
  PhotoSensor other(faults, Random(2));
  EXPECT_EQ(one.bench(0.5), same.bench(0.5));
  EXPECT_NE(one.bench(0.5), other.bench(0.5));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(one.read(0.3, 0.01 * i), same.read(0.3, 0.01 * i));
}

}  // namespace
}  // namespace mien::virt::photo_sensor_test
