#include "mien/imu/heading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mien/core/random.h"
#include "mien/core/units.h"

namespace mien::imu::heading_test {
namespace {

Quat about(const Vec3& axis, double angle) {
  return Quat(Eigen::AngleAxisd(angle, axis));
}

TEST(HeadingSums, ANodFindsAnyHeading) {
  Random random(1);
  for (int trial = 0; trial < 30; ++trial) {
    const double heading = random.uniform(-180, 180) * kRadPerDeg;
    const Quat ear_mount = random.rotation();
    const Quat face_mount = random.rotation();
    HeadingSums sums;
    for (int i = 0; i < 120; ++i) {
      const Quat head = about(Vec3::UnitX(), 15 * kRadPerDeg * std::sin(0.1 * i));
      // The face's fusion reads the world turned by -heading.
      sums.add(head * ear_mount, heading_turn(-heading) * head * face_mount);
    }
    const auto best = sums.find();
    EXPECT_NEAR(std::remainder(best.heading_rad - heading, 2 * std::numbers::pi), 0, 1e-5);
    EXPECT_LT(best.sigma_rad, 0.1 * kRadPerDeg);
    EXPECT_LT(sums.spread(best.heading_rad), 0.01 * kRadPerDeg);
    EXPECT_LT(angle_between(sums.mean(best.heading_rad), ear_mount.conjugate() * face_mount), 1e-5);
  }
}

TEST(HeadingSums, AShakeAboutTheVerticalTellsNothing) {
  HeadingSums sums;
  for (int i = 0; i < 120; ++i) {
    const Quat head = about(Vec3::UnitY(), 30 * kRadPerDeg * std::sin(0.1 * i));
    sums.add(head, heading_turn(1) * head);
  }
  EXPECT_GT(sums.find().sigma_rad, 90 * kRadPerDeg);
  EXPECT_GT(HeadingSums().find().sigma_rad, 90 * kRadPerDeg);
}

TEST(HeadingSums, NoiseIsSaid) {
  Random random(2);
  HeadingSums sums;
  for (int i = 0; i < 120; ++i) {
    const Quat head = about(Vec3::UnitX(), 10 * kRadPerDeg * std::sin(0.1 * i));
    const Quat noise =
        exp_rotation(1.0 * kRadPerDeg * Vec3{random.normal(), random.normal(), random.normal()});
    sums.add(head, heading_turn(-0.5) * head * noise);
  }
  const auto best = sums.find();
  EXPECT_NEAR(best.heading_rad, 0.5, 3 * best.sigma_rad);
  EXPECT_GT(best.sigma_rad, 2 * kRadPerDeg);
}

}  // namespace
}  // namespace mien::imu::heading_test
