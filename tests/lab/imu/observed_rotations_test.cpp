#include "lab/imu/observed_rotations.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/virtual/three_sensors.h"

namespace mien::lab::observed_rotations_test {
namespace {

model::FeatureFrame frame(double chin_turn_rad, bool cheek_there) {
  model::FeatureFrame out;
  out.sensors.resize(2);
  const Quat turn = exp_rotation(Vec3(chin_turn_rad, 0, 0));
  out.sensors[0].rotation = {static_cast<float>(turn.w()), static_cast<float>(turn.x()),
                             static_cast<float>(turn.y()), static_cast<float>(turn.z())};
  out.sensors[0].has_rotation = true;
  out.sensors[1].rotation = {1, 0, 0, 0};
  out.sensors[1].has_rotation = cheek_there;
  return out;
}

TEST(ObservedRotations, CountsThemAndTheirErrors) {
  const auto sites = virt::test::three_sites();
  ObservedRotations rotations(virt::test::three_sensors());
  EXPECT_EQ(rotations.share(), 0);
  EXPECT_EQ(rotations.rms_rad(), 0);
  rotations.add(frame(0.1, true), {}, sites);  // The truth is neutral: no turn at all.
  rotations.add(frame(0, false), {}, sites);
  EXPECT_DOUBLE_EQ(rotations.share(), 0.75);
  EXPECT_DOUBLE_EQ(rotations.share(0), 1);
  EXPECT_DOUBLE_EQ(rotations.share(1), 0.5);
  EXPECT_NEAR(rotations.rms_rad(), 0.1 / std::sqrt(3.0), 1e-6);
  ObservedRotations more = rotations;
  more.add(rotations);
  EXPECT_DOUBLE_EQ(more.share(), 0.75);
  EXPECT_NEAR(more.rms_rad(), rotations.rms_rad(), 1e-12);
}

}  // namespace
}  // namespace mien::lab::observed_rotations_test
