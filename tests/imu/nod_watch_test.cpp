#include "mien/imu/nod_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/units.h"
#include "mien/imu/heading.h"

namespace mien::imu::nod_watch_test {
namespace {

constexpr double kFrame_s = 1 / 60.0;

Quat about(const Vec3& axis, double angle) {
  return Quat(Eigen::AngleAxisd(angle, axis));
}

/// A face sensor on a moving head, at 60 Hz.
struct Head {
  double nod_rad = 15 * kRadPerDeg, turn_rad = 30 * kRadPerDeg;
  double heading_error_rad = 0;          ///< Of the face sensor.
  Vec3 tilt_error_rad = Vec3::Zero();    ///< Of its inclination, world axes.
  double noise_rad = 0;                  ///< Of each frame's orientation, an axis.
  std::function<Vec3(double)> face_rad;  ///< Rotation vector of the face, ear sensor's axes; none: still.

  [[nodiscard]] Head still() const {
    Head head = *this;
    head.face_rad = nullptr;
    return head;
  }
  [[nodiscard]] Quat world_ear(double t) const {
    return about(Vec3::UnitY(), turn_rad * std::sin(2.2 * t)) *
           about(Vec3::UnitX(), nod_rad * std::sin(3.1 * t)) * about(Vec3(0.6, 0, 0.8), 0.4);
  }

  std::optional<NodMeasurement> add_to(NodWatch& watch, double t, Random& random) const {
    const Quat head = world_ear(t);
    const auto face = [&](double at) { return face_rad ? exp_rotation(face_rad(at)) : Quat::Identity(); };
    const Quat error = heading_turn(heading_error_rad) * exp_rotation(tilt_error_rad) *
                       exp_rotation(random.normal_vector(noise_rad));
    const Quat relative = head.conjugate() * error * head * face(t) * about(Vec3::UnitZ(), 1.1);
    return watch.add(kFrame_s, relative, head,
                     log_rotation(face(t + kFrame_s) * face(t).conjugate()) / kFrame_s,
                     log_rotation(head.conjugate() * world_ear(t + kFrame_s)) / kFrame_s);
  }

  [[nodiscard]] std::vector<NodMeasurement> measure(double seconds, const NodSettings& settings = {}) const {
    NodWatch watch(settings);
    Random random(3);
    std::vector<NodMeasurement> found;
    for (int i = 0; i < std::lround(seconds / kFrame_s); ++i)
      if (const auto nod = add_to(watch, i * kFrame_s, random)) found.push_back(*nod);
    return found;
  }
};

TEST(NodWatch, AStillFaceOnANoddingHeadMeasuresItsHeadingError) {
  for (const double error_deg : {-8.0, -1.0, 0.0, 2.0, 8.0}) {
    const Head head{.heading_error_rad = error_deg * kRadPerDeg,
                    .tilt_error_rad = Vec3(1, 0, -1) * kRadPerDeg,
                    .noise_rad = 0.2 * kRadPerDeg};
    const auto found = head.measure(30);
    EXPECT_GE(found.size(), 8) << error_deg;
    for (const NodMeasurement& nod : found) {
      EXPECT_NEAR(nod.error_rad, head.heading_error_rad, 3 * nod.sigma_rad) << error_deg;
      EXPECT_LT(nod.sigma_rad, 1 * kRadPerDeg);
      EXPECT_GT(nod.sigma_rad, 0.1 * kRadPerDeg);
    }
  }
}

TEST(NodWatch, AHeadThatOnlyTurnsAboutTheVerticalMeasuresNothing) {
  const Head nodding{.heading_error_rad = 3 * kRadPerDeg};
  EXPECT_FALSE(nodding.measure(30).empty());
  Head turning = nodding;
  turning.nod_rad = 0;
  EXPECT_TRUE(turning.measure(30).empty());
  turning.turn_rad = 0;
  EXPECT_TRUE(turning.measure(30).empty());
}

TEST(NodWatch, AMovingFaceMeasuresNothing) {
  Head head{.heading_error_rad = 3 * kRadPerDeg};
  head.face_rad = [](double t) { return Vec3(0, 0.1 * std::sin(7 * t), 0.1 * std::cos(7 * t)); };
  EXPECT_TRUE(head.measure(60).empty());
  // So slowly that its rate passes, under nods so slight that a stretch takes three seconds.
  head.nod_rad = 10 * kRadPerDeg;
  head.turn_rad = 0;
  EXPECT_FALSE(head.still().measure(60).empty());
  head.face_rad = [](double t) { return Vec3(0.08 * std::sin(0.8 * t), 0, 0.08 * std::cos(0.8 * t)); };
  EXPECT_TRUE(head.measure(60).empty());
  NodSettings unguarded;
  unguarded.max_residual_rad = 1;
  EXPECT_FALSE(head.measure(60, unguarded).empty()) << "only the residual shows this motion";
}

TEST(NodWatch, AnInterruptionEndsTheStretch) {
  // Whole stretches take up to two seconds: none fits between interruptions.
  const auto count = [](int interrupted_every) {
    const Head head{.heading_error_rad = 3 * kRadPerDeg};
    NodWatch watch;
    Random random(4);
    int found = 0;
    for (int i = 0; i < 60 * 30; ++i) {
      if (i % interrupted_every == 0) watch.interrupt();
      found += head.add_to(watch, i * kFrame_s, random).has_value() ? 1 : 0;
    }
    return found;
  };
  EXPECT_EQ(count(40), 0);
  EXPECT_GT(count(10'000), 8);

  // A heading that is moved within a stretch: what comes after an interruption is of the new heading alone.
  Head head{.heading_error_rad = 10 * kRadPerDeg};
  NodWatch watch;
  Random random(4);
  int found = 0;
  for (int i = 0; i < 60 * 10; ++i) {
    if (i == 60) {
      EXPECT_EQ(found, 0) << "the move must fall within a stretch";
      head.heading_error_rad = 2 * kRadPerDeg;
      watch.interrupt();
    }
    if (const auto nod = head.add_to(watch, i * kFrame_s, random)) {
      ++found;
      EXPECT_NEAR(nod->error_rad, 2 * kRadPerDeg, 0.05 * kRadPerDeg);
    }
  }
  EXPECT_GT(found, 1);
}

TEST(NodWatch, AStretchOfTooLittleInformationMeasuresNothing) {
  // The vertical's squared path in the longest stretch: 240 frames of (8 deg)^2 / 2 are 2.3 rad^2.
  const Head slight{.nod_rad = 8 * kRadPerDeg, .heading_error_rad = 3 * kRadPerDeg};
  NodSettings settings;
  ASSERT_EQ(settings.min_information, 3);
  EXPECT_TRUE(slight.measure(60, settings).empty());
  settings.min_information = 1;
  EXPECT_FALSE(slight.measure(60, settings).empty());
  // The more is asked for, the rarer and the more certain.
  const Head head{.turn_rad = 0, .heading_error_rad = 3 * kRadPerDeg};
  const auto soon = head.measure(60, settings);
  settings.min_information = 6;
  const auto late = head.measure(60, settings);
  ASSERT_FALSE(late.empty());
  EXPECT_GT(soon.size(), 2 * late.size());
  EXPECT_LT(late.front().sigma_rad, 0.6 * soon.front().sigma_rad);
}

}  // namespace
}  // namespace mien::imu::nod_watch_test
