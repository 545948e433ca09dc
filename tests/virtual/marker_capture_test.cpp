#include "mien/virtual/marker_capture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::virt {
namespace {

const std::vector<Vec3> kPlaces = {Vec3(0, 0, 0.1), Vec3(0.01, 0, 0.1), Vec3(0.05, 0, 0.1)};

Eigen::VectorXd truth() {
  Eigen::VectorXd markers(9);
  for (std::size_t i = 0; i < 3; ++i) markers.segment<3>(3 * static_cast<Eigen::Index>(i)) = kPlaces[i];
  return markers;
}

TEST(MarkerCapture, PerfectCaptureIsTheTruth) {
  MarkerCapture capture(EyewearFaults{}, kPlaces, Random(1));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(capture.capture(i, truth()), truth());
}

TEST(MarkerCapture, JittersByWhatIsAsked) {
  EyewearFaults faults;
  faults.marker_jitter_mm = 0.2;
  MarkerCapture capture(faults, kPlaces, Random(1));
  double squares = 0;
  for (int i = 0; i < 1000; ++i) squares += (capture.capture(i, truth()) - truth()).squaredNorm();
  EXPECT_NEAR(std::sqrt(squares / 9000), 0.0002, 1e-5);
}

TEST(MarkerCapture, NeighboursChangeNames) {
  EyewearFaults faults;
  faults.mislabel_per_min = 30;
  faults.mislabel_s = 1;
  MarkerCapture capture(faults, kPlaces, Random(1));
  int swapped = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::VectorXd seen = capture.capture(0.1 * i, truth());
    if (seen == truth()) continue;
    ++swapped;
    // Marker 2's nearest is 1: marker 0 never takes 2's name.
    EXPECT_NE(Vec3(seen.head<3>()), kPlaces[2]);
    EXPECT_NEAR(seen.sum(), truth().sum(), 1e-12);
  }
  EXPECT_NEAR(swapped / 3000.0, 1.0 / 3, 0.08);
}

TEST(MarkerCapture, CoveredMarkersAreFoundElsewhere) {
  EyewearFaults faults;
  faults.lost_per_min = 20;
  faults.lost_s = 0.5;
  faults.lost_mm = 30;
  MarkerCapture capture(faults, kPlaces, Random(1));
  int lost = 0;
  for (int i = 0; i < 3000; ++i)
    if (capture.capture(0.1 * i, truth()) != truth()) ++lost;
  EXPECT_NEAR(lost / 3000.0, 1.0 / 7, 0.05);
}

}  // namespace
}  // namespace mien::virt
