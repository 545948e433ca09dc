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

/// P of a still face whose heading is `error` off, on a head that nods and turns.
struct Still {
  static Quat head(double t) {
    return about(Vec3::UnitY(), 30 * kRadPerDeg * std::sin(2.2 * t)) *
           about(Vec3::UnitX(), 15 * kRadPerDeg * std::sin(3.1 * t));
  }
};

TEST(HeadingTracker, FollowsADriftWhileTheHeadNods) {
  HeadingTracker tracker;
  tracker.start(0.3, 0.5 * kRadPerDeg);
  double truth = 0.3;
  for (int i = 0; i < 60 * 60; ++i) {
    const double t = i / 60.0;
    truth += 0.05 * kRadPerDeg / 60;
    const Quat head = Still::head(t);
    const Quat relative = head.conjugate() * heading_turn(tracker.heading_rad() - truth) * head;
    tracker.add(1 / 60.0, relative, head, Vec3::Zero(), Vec3::Zero());
    if (t > 20) {
      EXPECT_NEAR(tracker.heading_rad(), truth, 0.4 * kRadPerDeg) << t;
    }
  }
  EXPECT_LT(tracker.sigma_rad(), 1 * kRadPerDeg);
}

TEST(HeadingTracker, FindsALostHeadingAgainByTheSkinThatStaysAway) {
  const HeadingSettings settings;
  // Heading 60 degrees off; expressions of up to 40 degrees on top, to neutral every other second.
  const auto off_after = [](double seconds, double sigma_rad) {
    HeadingTracker tracker;
    tracker.start(60 * kRadPerDeg, sigma_rad);
    for (int i = 0; i < static_cast<int>(60 * seconds); ++i) {
      const double skin = 40 * kRadPerDeg * std::max(0.0, std::sin(std::numbers::pi * i / 60.0));
      // A face that moves: nothing tells the heading but where the skin is.
      tracker.add(1 / 60.0, Quat::Identity(), Quat::Identity(), Vec3(0, 1, 0), Vec3::Zero());
      tracker.add_turn_from_neutral(1 / 60.0, tracker.heading_rad() + skin, 0);
    }
    return tracker.heading_rad();
  };
  EXPECT_GT(off_after(settings.lost_after_s - 0.5, 10 * kRadPerDeg),
            50 * kRadPerDeg);  // It may be an expression.
  EXPECT_NEAR(off_after(settings.lost_after_s + 0.5, 10 * kRadPerDeg), 0, 8 * kRadPerDeg);
  EXPECT_NEAR(off_after(30, 10 * kRadPerDeg), 0, 8 * kRadPerDeg);
  EXPECT_GT(off_after(30, 3 * kRadPerDeg), 50 * kRadPerDeg);  // Sure of itself: the face holds an expression.
}

/// A face that never stands still, about a rest some degrees away from its neutral, on a sensor whose heading
/// drifts by a degree a minute: how far off the heading is after ten minutes.
double off_after_ten_minutes(const HeadingSettings& settings, double rest_rad) {
  HeadingTracker tracker(settings);
  tracker.start(0, 0.5 * kRadPerDeg);
  double truth = 0;
  for (int i = 0; i < 60 * 600; ++i) {
    const double t = i / 60.0;
    truth += 1 * kRadPerDeg / 3600;
    const double skin = rest_rad + 8 * kRadPerDeg * std::sin(1.7 * t) * std::sin(0.3 * t);
    tracker.add(1 / 60.0, Quat::Identity(), Quat::Identity(), Vec3(0, 1, 0), Vec3::Zero());
    tracker.add_turn_from_neutral(1 / 60.0, tracker.heading_rad() - truth + skin, 0);
  }
  return std::abs(tracker.heading_rad() - truth);
}

TEST(HeadingTracker, LearnsWhereAFaceRestsWhileTheHeadingIsFresh) {
  HeadingSettings at_neutral;
  at_neutral.rest_sigma_rad = 0;
  EXPECT_LT(off_after_ten_minutes({}, 0), 2 * kRadPerDeg);
  EXPECT_LT(off_after_ten_minutes({}, 6 * kRadPerDeg), 2 * kRadPerDeg);
  EXPECT_LT(off_after_ten_minutes({}, -6 * kRadPerDeg), 2 * kRadPerDeg);
  EXPECT_GT(off_after_ten_minutes(at_neutral, 6 * kRadPerDeg), 4 * kRadPerDeg);
}

TEST(HeadingTracker, ATiltedFaceWeighsLess) {
  const auto pulled_by = [](double tilt_rad) {
    HeadingTracker tracker;
    tracker.start(0, 5 * kRadPerDeg);
    for (int i = 0; i < 60 * 10; ++i)
      tracker.add_turn_from_neutral(1 / 60.0, tracker.heading_rad() + 4 * kRadPerDeg, tilt_rad);
    return -tracker.heading_rad();
  };
  EXPECT_GT(pulled_by(0), 1.5 * pulled_by(40 * kRadPerDeg));
  EXPECT_GT(pulled_by(40 * kRadPerDeg), 0);
}

/// A residual about the vertical of this angle, with this standard deviation of the prediction.
SkinMeasurement residual(double turn_rad, double sigma_rad, double strength = 1) {
  return {.residual_rad = Vec3(0, turn_rad, 0),
          .heading_jacobian = Vec3::UnitY(),
          .residual_cov_rad2 = sigma_rad * sigma_rad * Mat3::Identity(),
          .strength = strength};
}

TEST(HeadingTracker, ASkinMeasurementPullsByItsCovariance) {
  // After ten seconds in which the skin is 4 degrees beyond its prediction, of this standard deviation.
  const auto pulled_by = [](double sigma_rad) {
    HeadingTracker tracker;
    tracker.start(0, 5 * kRadPerDeg, sigma_rad * sigma_rad * Mat3::Identity());
    for (int i = 0; i < 60 * 10; ++i)
      tracker.add_skin(1 / 60.0, residual(tracker.heading_rad() + 4 * kRadPerDeg, sigma_rad));
    return -tracker.heading_rad();
  };
  EXPECT_GT(pulled_by(1 * kRadPerDeg), 3.5 * kRadPerDeg);
  EXPECT_LT(pulled_by(8 * kRadPerDeg), 0.6 * pulled_by(1 * kRadPerDeg));
  EXPECT_GT(pulled_by(8 * kRadPerDeg), 0);
}

TEST(HeadingTracker, LearnsTheWearersSkinWhileTheHeadingIsFresh) {
  // Four degrees beyond the prediction, for a minute: with a fresh heading that is how this skin turns.
  HeadingTracker tracker;
  tracker.start(0, 0.5 * kRadPerDeg, Mat3((4 * kRadPerDeg) * (4 * kRadPerDeg) * Mat3::Identity()));
  for (int i = 0; i < 60 * 60; ++i) {
    tracker.skip(1 / 60.0);
    tracker.add_skin(1 / 60.0, residual(tracker.heading_rad() + 4 * kRadPerDeg, 4 * kRadPerDeg));
  }
  EXPECT_LT(std::abs(tracker.heading_rad()), 1.5 * kRadPerDeg);
}

TEST(HeadingTracker, SeparatesTheWearersSkinFromTheHeadingByHowStronglyAFaceMoves) {
  // The heading is five degrees off, and the wearer's skin turns by six more: the latter only while the face
  // moves.
  const auto left = [](double strength_at_rest) {
    HeadingTracker tracker;
    tracker.start(5 * kRadPerDeg, 2 * kRadPerDeg,
                  Mat3((4 * kRadPerDeg) * (4 * kRadPerDeg) * Mat3::Identity()));
    for (int i = 0; i < 60 * 60; ++i) {
      tracker.skip(1 / 60.0);
      const double strength = i / 60 % 2 == 0 ? 1 : strength_at_rest;
      tracker.add_skin(1 / 60.0,
                       residual(tracker.heading_rad() + strength * 6 * kRadPerDeg, 4 * kRadPerDeg, strength));
    }
    return std::abs(tracker.heading_rad());
  };
  EXPECT_LT(left(0.2), 0.5 * left(1));
  EXPECT_GT(left(1), 1 * kRadPerDeg) << "always moving alike, they cannot be separated";
}

TEST(HeadingTracker, WhatAFaceAtRestKeepsIsTheSensorsCreep) {
  // In five minutes a sensor creeps by three degrees of tilt. The same of a face that always moves may be the
  // wearer's skin.
  const auto creep = [](double strength, double walk) {
    HeadingSettings settings;
    settings.slip_walk = walk;
    HeadingTracker tracker(settings);
    tracker.start(0, 0.5 * kRadPerDeg, Mat3((4 * kRadPerDeg) * (4 * kRadPerDeg) * Mat3::Identity()));
    constexpr int kFrames = 60 * 300;
    for (int i = 0; i < kFrames; ++i) {
      tracker.skip(1 / 60.0);
      SkinMeasurement measurement = residual(tracker.heading_rad(), 4 * kRadPerDeg, strength);
      measurement.residual_rad.x() = 3 * kRadPerDeg * i / kFrames - tracker.slip_rad().x();
      tracker.add_skin(1 / 60.0, measurement);
    }
    return tracker.slip_rad();
  };
  const double walk = HeadingSettings().slip_walk;
  EXPECT_LT((creep(0.15, walk) - Vec3(3 * kRadPerDeg, 0, 0)).norm(), 0.5 * kRadPerDeg);
  EXPECT_LT(creep(3, walk).norm(), 2 * kRadPerDeg);
  EXPECT_EQ(creep(0.15, 0), Vec3(Vec3::Zero())) << "glue that holds";
  // A fusion that restarts is on the same skin.
  HeadingTracker tracker;
  tracker.start(0, 0.5 * kRadPerDeg, Mat3((4 * kRadPerDeg) * (4 * kRadPerDeg) * Mat3::Identity()));
  for (int i = 0; i < 60 * 300; ++i) {
    tracker.skip(1 / 60.0);
    SkinMeasurement measurement = residual(tracker.heading_rad(), 4 * kRadPerDeg, 0.15);
    measurement.residual_rad.z() = 1e-4 * kRadPerDeg * i - tracker.slip_rad().z();
    tracker.add_skin(1 / 60.0, measurement);
  }
  const Vec3 crept = tracker.slip_rad();
  EXPECT_GT(crept.z(), 0.5 * kRadPerDeg);
  tracker.move_to(2, 10 * kRadPerDeg);
  EXPECT_EQ(tracker.slip_rad(), crept);
  EXPECT_EQ(tracker.heading_rad(), 2);
  EXPECT_NEAR(tracker.sigma_rad(), 10 * kRadPerDeg, 1e-9);
}

TEST(HeadingTracker, KeepsACovarianceThroughAMillionUpdates) {
  // Twelve hours of a face that moves strongly and weakly, of a head that nods, and of gaps.
  HeadingTracker tracker;
  tracker.start(0, 1 * kRadPerDeg, Mat3((3 * kRadPerDeg) * (3 * kRadPerDeg) * Mat3::Identity()));
  Random random(5);
  for (int i = 0; i < 1'000'000; ++i) {
    const double t = 0.045 * i;
    if (i % 5000 == 0) tracker.inflate(8 * kRadPerDeg);
    if (i % 7 == 0)
      tracker.add(0.045, Quat::Identity(), Still::head(t), Vec3(0, i % 1000 < 500 ? 0 : 1, 0), Vec3::Zero());
    else
      tracker.skip(0.045);
    const double sigma = (0.3 + 3 * std::abs(std::sin(0.01 * t))) * kRadPerDeg;
    SkinMeasurement measurement = residual(0, sigma, 0.15 + std::abs(std::sin(0.3 * t)));
    measurement.residual_rad = sigma * Vec3(random.normal(), random.normal(), random.normal());
    measurement.heading_jacobian = Still::head(t) * Vec3::UnitY();
    tracker.add_skin(0.045, measurement);
    if (i % 500 == 0) {
      ASSERT_TRUE(tracker.sound()) << i;
    }
  }
  EXPECT_GT(tracker.sigma_rad(), 0.1 * kRadPerDeg);
  EXPECT_LT(tracker.sigma_rad(), 5 * kRadPerDeg);
}

TEST(HeadingTracker, GrowsUncertainWithoutMeasurements) {
  HeadingTracker turning;
  HeadingTracker moving;
  HeadingTracker missing;
  for (HeadingTracker* tracker : {&turning, &moving, &missing}) tracker->start(0, 0.3 * kRadPerDeg);
  double last = 0;
  for (int i = 0; i < 60 * 20; ++i) {
    const double t = i / 60.0;
    const Quat head = about(Vec3::UnitY(), std::sin(t));
    turning.add(1 / 60.0, Quat::Identity(), head, Vec3::Zero(), Vec3::Zero());
    // A face that talks: its turns must not be taken for the heading's.
    moving.add(1 / 60.0, exp_rotation(0.3 * std::sin(8 * t) * Vec3::UnitZ()), Still::head(t), Vec3(0, 0, 1.5),
               Vec3::Zero());
    missing.skip(1 / 60.0);
    if (i % 60 == 0) {
      EXPECT_GE(turning.sigma_rad(), last);
      last = turning.sigma_rad();
    }
  }
  for (const HeadingTracker* tracker : {&turning, &moving, &missing}) {
    EXPECT_EQ(tracker->heading_rad(), 0);
    EXPECT_GT(tracker->sigma_rad(), 1 * kRadPerDeg);
  }
}

}  // namespace
}  // namespace mien::imu::heading_test
