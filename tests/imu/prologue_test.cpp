#include "mien/imu/prologue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mien/core/units.h"

namespace mien::imu::prologue_test {
namespace {

constexpr double kFrame_s = 1 / 60.0;
constexpr double kAhead_m = 0.09;

sensor::Rig two_sensors() {
  sensor::Rig rig;
  rig.name = "test";
  rig.reference = "ear";
  sensor::Mount face;
  face.name = "face";
  face.kind = "imu";
  face.role = "face";
  sensor::Mount ear = face;
  ear.name = "ear";
  ear.role = "head";
  rig.sensors = {face, ear};
  return rig;
}

/// A head that holds still, then nods 18 degrees down and up, its sensors' axes along its own.
/// `change(frame, pitch_rad, turn_rad_s2)` may spoil what is seen of the nod.
template <class Change>
Calibration nod(double cycles_a_second, Change&& change) {
  Prologue prologue(two_sensors());
  Prologue::Frame frame;
  frame.face.resize(1);
  frame.face[0].present = true;
  int count = 0;
  const auto set = [&](double pitch_rad, double rate_rad_s, double turn_rad_s2) {
    frame.time = DeviceTime(from_seconds(kFrame_s * ++count));
    frame.q_world_ear = frame.face[0].q_world_face = exp_rotation(pitch_rad * Vec3::UnitX());
    frame.ear_rate_rad_s = frame.face[0].rate_rad_s = rate_rad_s * Vec3::UnitX();
    // What is ahead goes down when the head does.
    frame.face[0].force_world_m_s2 = Vec3(0, 9.81 - kAhead_m * turn_rad_s2, 0);
    frame.ear_force_world_m_s2 = Vec3(0, 9.81, 0);
  };
  prologue.begin_neutral();
  for (int i = 0; i < 120; ++i) {
    set(0, 0, 0);
    prologue.add_neutral(frame);
  }
  prologue.begin_nod();
  const double w = 2 * std::numbers::pi * cycles_a_second;
  for (double t = 0; t < 2 / cycles_a_second; t += kFrame_s) {
    const double pitch = 18 * kRadPerDeg * std::sin(w * t), turn = -w * w * pitch;
    set(pitch, 18 * kRadPerDeg * w * std::cos(w * t), turn);
    change(frame, pitch, turn);
    prologue.add_nod(frame);
  }
  return prologue.solve();
}

double turned_round(const Calibration& calibration) {
  EXPECT_TRUE(calibration.complete);
  return angle_between(calibration.q_head_ear, Quat::Identity());
}

TEST(Prologue, ANodsSwingTellsWhichWayIsAhead) {
  EXPECT_LT(turned_round(nod(0.6, [](Prologue::Frame&, double, double) {})), 1 * kRadPerDeg);
  // As of a face behind the ear: that is a head that looks the other way.
  const Calibration other = nod(0.6, [](Prologue::Frame& frame, double, double turn) {
    frame.face[0].force_world_m_s2.y() = 9.81 + kAhead_m * turn;
  });
  EXPECT_NEAR(turned_round(other), std::numbers::pi, 1 * kRadPerDeg);
}

TEST(Prologue, WhatWasHeldOverAGapTellsNothingOfTheSwing) {
  // Every third frame is none of its own, and would tell the opposite.
  for (const bool ear : {true, false}) {
    int count = 0;
    const Calibration found = nod(0.6, [&](Prologue::Frame& frame, double, double turn) {
      const bool held = ++count % 3 == 0;
      (ear ? frame.ear_fresh : frame.face[0].fresh) = !held;
      if (held) frame.face[0].force_world_m_s2.y() = 9.81 + 6 * kAhead_m * turn;
    });
    EXPECT_LT(turned_round(found), 1 * kRadPerDeg) << (ear ? "ear" : "face");
  }
}

TEST(Prologue, OfASlowNodAccelerometersFaultsAreNotTakenForItsSwing) {
  const auto faulty = [](Prologue::Frame& frame, double pitch, double) {
    frame.face[0].force_world_m_s2.y() -= 0.3 * pitch;
  };
  EXPECT_LT(turned_round(nod(0.1, faulty)), 1 * kRadPerDeg);
  EXPECT_LT(turned_round(nod(0.6, faulty)), 1 * kRadPerDeg);
}

}  // namespace
}  // namespace mien::imu::prologue_test
