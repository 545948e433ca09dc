#include "mien/virtual/imu/imu_simulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mien/core/files.h"
#include "mien/core/units.h"
#include "mien/sensor/rig.h"
#include "tests/project_path.h"

namespace mien::virt::imu_simulator_test {
namespace {

/// One site 12 cm before the head's origin that jawOpen turns about X.
SkinSite site_turned_by_jaw() {
  SkinSite site;
  site.sensor = "mentalis";
  site.position_m = Vec3(0, 0, 0.12);
  site.covariance = Vec3(1e-5, 1e-5, 1e-7).asDiagonal();
  for (auto& c : site.shape_covariance) c.setZero();
  for (auto& d : site.shape_shift_m) d.setZero();
  // Points p = (x, y, 0) moved by (0, 0, 0.3 y): a turn of about 0.3 rad about +X.
  site.shape_covariance[face::shape("jawOpen")](1, 2) = 0.3 * 1e-5;
  site.shape_shift_m[face::shape("jawOpen")] = Vec3(0, -0.02, 0);
  return site;
}

face::Motion nodding_and_talking(double seconds) {
  face::Motion motion;
  for (int f = 0; f <= seconds * 60; ++f) {
    face::MotionFrame frame;
    frame.time_s = f / 60.0;
    frame.head = exp_rotation(Vec3(0.35 * std::sin(2 * std::numbers::pi * 0.5 * frame.time_s), 0, 0));
    frame.weights[face::shape("jawOpen")] =
        static_cast<float>(0.5 - 0.5 * std::cos(2 * std::numbers::pi * 1.5 * frame.time_s));
    motion.frames.push_back(frame);
  }
  return motion;
}

DeviceFaults perfect() {
  return {};
}

struct Played {
  SkinTrajectory trajectory;
  std::vector<SkinSite> sites;
  std::vector<VirtualPacket> packets;
  VirtualClock clock;
};

Played play(const DeviceFaults& faults, const face::Motion& motion, std::uint64_t seed) {
  Played out;
  out.sites = {site_turned_by_jaw()};
  out.trajectory = trace_skin(face::MotionCurve(motion), out.sites, 0, motion.duration_s());
  ImuSimulator simulator(faults, 0, Random(seed));
  out.clock = simulator.clock();
  for (VirtualPacket& packet : simulator.play(out.trajectory))
    if (!packet.lost) out.packets.push_back(std::move(packet));
  return out;
}

Quat truth_at(const Played& played, double true_s) {
  const double at = true_s * kTrajectoryRateHz;
  const auto i = static_cast<std::size_t>(at);
  const auto pose = [&](std::size_t j) {
    return played.trajectory.head[j] * played.trajectory.rotation[0][j];
  };
  return interpolate_rotation(pose(i - 1), pose(i), pose(i + 1), pose(i + 2), at - static_cast<double>(i));
}

TEST(ImuSimulator, PerfectGyroIntegratesToTheSkinsOrientation) {
  const Played played = play(perfect(), nodding_and_talking(4), 1);
  ASSERT_GT(played.packets.size(), 200U);
  const double period_s = 1 / kImuRateHz;
  const double start_s = played.clock.true_s(played.packets.front().samples.front().time) - period_s / 2;
  const Quat mount =
      truth_at(played, start_s).conjugate() * truth_at(played, start_s);  // Identity: no mounting fault.
  Quat q = truth_at(played, start_s) * mount;
  double t = start_s;
  double worst = 0;
  for (const auto& packet : played.packets)
    for (const auto& s : packet.samples) {
      q = q * exp_rotation(Vec3(s.values[0], s.values[1], s.values[2]) * period_s);
      t += period_s;
      worst = std::max(worst, angle_between(q, truth_at(played, t)));
    }
  // Quantisation to 16 bits of 1024 dps is all that is left: a random walk far below a tenth of a degree.
  EXPECT_LT(worst, 0.1 * kRadPerDeg);
}

TEST(ImuSimulator, AtRestTheAccelerometerReadsGravityUpwards) {
  face::Motion still;
  for (int f = 0; f < 120; ++f) still.frames.push_back({.time_s = f / 60.0});
  const Played played = play(perfect(), still, 1);
  for (const auto& packet : played.packets)
    for (const auto& s : packet.samples) {
      EXPECT_NEAR(s.values[3], 0, 0.003);
      EXPECT_NEAR(s.values[4], 9.80665, 0.003);
      EXPECT_NEAR(s.values[5], 0, 0.003);
      for (int i = 0; i < 3; ++i) EXPECT_EQ(s.values[static_cast<std::size_t>(i)], 0);
    }
}

TEST(ImuSimulator, LeverArmFeelsTheNod) {
  // A nod of amplitude A at f Hz with an arm r: tangential acceleration peaks at A (2 pi f)^2 r.
  face::Motion motion = nodding_and_talking(4);
  for (auto& frame : motion.frames) frame.weights = {};
  const Played played = play(perfect(), motion, 1);
  double peak = 0;
  for (const auto& packet : played.packets)
    for (const auto& s : packet.samples) {
      const double t = played.clock.true_s(s.time);
      if (t < 0.2 || t > 3.8) continue;  // The motion starts and stops in mid-nod.
      const Vec3 force(s.values[3], s.values[4], s.values[5]);
      const Vec3 linear = truth_at(played, t) * force - Vec3(0, 9.80665, 0);
      peak = std::max(peak, linear.norm());
    }
  const double omega = 2 * std::numbers::pi * 0.5;
  EXPECT_NEAR(peak, 0.35 * omega * omega * 0.12, 0.05);
}

TEST(ImuSimulator, ClocksRunAtTheirOwnRateAndStart) {
  DeviceFaults faults;
  faults.clock_offset_s = {30, 40};
  faults.clock_drift_ppm = 50;
  const Played played = play(faults, nodding_and_talking(2), 9);
  EXPECT_GE(played.clock.offset_s, 30);
  EXPECT_LE(played.clock.offset_s, 40);
  EXPECT_NE(played.clock.rate, 1);
  EXPECT_NEAR(played.clock.true_s(played.clock.device(1.25)), 1.25, 1e-8);
  for (std::size_t p = 1; p < played.packets.size(); ++p) {
    EXPECT_EQ(played.packets[p].samples[0].sequence, played.packets[p - 1].samples[0].sequence + 1);
    const double step_s =
        to_seconds(played.packets[p].samples[0].time - played.packets[p - 1].samples[3].time);
    EXPECT_NEAR(step_s, 1 / kImuRateHz, 1e-8);
  }
}

TEST(ImuSimulator, LosesThePacketsThatItIsToldToLose) {
  DeviceFaults faults;
  faults.packet_loss = 0.2;
  const Played whole = play(perfect(), nodding_and_talking(10), 3);
  const Played lossy = play(faults, nodding_and_talking(10), 3);
  const double kept = static_cast<double>(lossy.packets.size()) / static_cast<double>(whole.packets.size());
  EXPECT_NEAR(kept, 0.8, 0.05);
}

TEST(ImuSimulator, OneSeedOneDevice) {
  const std::string path = project_path("rigs/default.toml");
  const auto rig = sensor::read_rig(path);
  ASSERT_TRUE(rig.has_value());
  const auto faults = parse_faults(rig->faults_toml, path);
  ASSERT_TRUE(faults.has_value()) << faults.error().message();
  const Played a = play(*faults, nodding_and_talking(2), 5);
  const Played b = play(*faults, nodding_and_talking(2), 5);
  const Played c = play(*faults, nodding_and_talking(2), 6);
  ASSERT_EQ(a.packets.size(), b.packets.size());
  for (std::size_t p = 0; p < a.packets.size(); ++p) {
    EXPECT_EQ(a.packets[p].arrival, b.packets[p].arrival);
    for (std::size_t s = 0; s < a.packets[p].samples.size(); ++s)
      EXPECT_EQ(a.packets[p].samples[s].values, b.packets[p].samples[s].values);
  }
  EXPECT_NE(a.packets[0].samples[0].values, c.packets[0].samples[0].values);
}

TEST(ImuSimulator, StretchByStretchTheDeviceIsTheSame) {
  const std::string path = project_path("rigs/default.toml");
  const DeviceFaults faults = parse_faults(sensor::read_rig(path).value().faults_toml, path).value();
  const face::Motion motion = nodding_and_talking(3);
  const face::MotionCurve curve(motion);
  const std::vector<SkinSite> sites = {site_turned_by_jaw()};
  ImuSimulator whole(faults, 0, Random(5));
  const auto expected = whole.play(trace_skin(curve, sites, 0, motion.duration_s()));
  ASSERT_GT(expected.size(), 150U);
  for (const std::size_t points : {1U, 7U, 60U}) {
    ImuSimulator simulator(faults, 0, Random(5));
    SkinTracer tracer([&](double time_s) { return curve.at(time_s); }, sites, 0, motion.duration_s());
    std::vector<VirtualPacket> packets;
    while (!tracer.done()) {
      const double before_s = tracer.traced_s();
      for (VirtualPacket& packet : simulator.play(tracer.next(points))) packets.push_back(std::move(packet));
      EXPECT_GT(tracer.traced_s(), before_s);
    }
    ASSERT_EQ(packets.size(), expected.size()) << points;
    for (std::size_t p = 0; p < packets.size(); ++p) {
      ASSERT_EQ(packets[p].arrival, expected[p].arrival);
      ASSERT_EQ(packets[p].lost, expected[p].lost);
      ASSERT_EQ(packets[p].samples.size(), 4U);
      for (std::size_t s = 0; s < 4; ++s) {
        ASSERT_EQ(packets[p].samples[s].time, expected[p].samples[s].time);
        ASSERT_EQ(packets[p].samples[s].values, expected[p].samples[s].values);
      }
    }
  }
}

TEST(DeviceFaults, EachWrongTableIsNamed) {
  EXPECT_EQ(parse_faults("gyro_bias_dps = -1", "rig.toml").error().code, ErrorCode::out_of_range);
  EXPECT_EQ(parse_faults("gyro_bias_dps = nan", "rig.toml").error().code, ErrorCode::out_of_range);
  EXPECT_EQ(parse_faults("gyro_bias_dps = \"much\"", "rig.toml").error().code, ErrorCode::malformed);
  EXPECT_EQ(parse_faults("gyro_bais_dps = 1", "rig.toml").error().code, ErrorCode::malformed);
  EXPECT_EQ(parse_faults("adhesive_lag_ms = [5]", "rig.toml").error().code, ErrorCode::malformed);
  EXPECT_EQ(parse_faults("adhesive_lag_ms = [9, 5]", "rig.toml").error().code, ErrorCode::out_of_range);
  EXPECT_EQ(parse_faults("packet_loss = 1.5", "rig.toml").error().code, ErrorCode::out_of_range);
  EXPECT_EQ(parse_faults("gyro_range_dps = 0", "rig.toml").error().code, ErrorCode::out_of_range);
  EXPECT_EQ(parse_faults("[", "rig.toml").error().code, ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::virt::imu_simulator_test
