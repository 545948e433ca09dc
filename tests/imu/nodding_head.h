#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/units.h"
#include "mien/imu/pipeline.h"
#include "mien/sensor/ticks.h"
#include "tests/imu/clocked_pipeline.h"

// A simulator of its own for the tests of this room: a still face on a moving head, with a rig's default
// faults. It shares nothing with the one that takes are made by, so that a mistake of sign in one is not
// excused by the other.
namespace mien::imu::testing_head {

struct Faults {
  double scale = 1;  // Of all of them but mounting, heading, clock offset.
  double arms = 1;   // 0 puts all sensors where the head turns: no fault, but nothing swings.
  double gyro_noise_dps_sqrt_hz = 0.015;
  double gyro_bias_dps = 1.0;
  double gyro_bias_walk_dps_sqrt_min = 0.05;
  double gyro_scale = 0.005;
  double accel_noise_ug_sqrt_hz = 200;
  double accel_bias_mg = 5;
  double accel_scale = 0.005;
  double clock_drift_ppm = 20;
  double radio_delay_ms = 3;
  double packet_loss = 0.005;
  double slip_deg_per_sqrt_min = 0.5;
};

inline double ease(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10 + u * (-15 + 6 * u));
}

/// Pitch (nod down positive), yaw (left positive), roll at a time: three seconds of neutral, a nod, a shake,
/// a pause, then a minute of nodding and turning at once.
struct Script {
  double nod_begin = 3.2, nod_end = 6.2, shake_begin = 6.4, shake_end = 9.4, move_begin = 10.0, end = 70.0;
  double nod_rad = 20 * kRadPerDeg, turn_rad = 40 * kRadPerDeg;
  double first_nod = 1;  // -1 begins upwards.
  double sway_rad = 0.1 * kRadPerDeg;

  [[nodiscard]] Vec3 angles(double t) const {
    Vec3 a = sway_rad * Vec3(std::sin(1.3 * t), std::sin(0.9 * t + 1), std::sin(1.1 * t + 2));
    const auto swing = [t](double begin, double stop, double cycles) {
      if (t <= begin || t >= stop) return 0.0;
      const double u = (t - begin) / (stop - begin);
      return std::sin(2 * std::numbers::pi * cycles * u) * ease(6 * u) * ease(6 * (1 - u));
    };
    a.x() += first_nod * 18 * kRadPerDeg * swing(nod_begin, nod_end, 2);
    a.y() += 25 * kRadPerDeg * swing(shake_begin, shake_end, 2);
    const double s = ease((t - move_begin) / 1.0);
    a.x() += s * nod_rad * std::sin(std::numbers::pi * (t - move_begin));
    a.y() += s * turn_rad * std::sin(std::numbers::pi * (t - move_begin) + 0.9);
    return a;
  }
  /// q_world_head.
  [[nodiscard]] Quat head(double t) const {
    const Vec3 a = angles(t);
    return Quat(Eigen::AngleAxisd(a.y(), Vec3::UnitY()) * Eigen::AngleAxisd(a.x(), Vec3::UnitX()) *
                Eigen::AngleAxisd(a.z(), Vec3::UnitZ()));
  }
};

/// A skin for record() that never turns from neutral.
inline Quat still_skin(std::size_t, double) {
  return Quat::Identity();
}

struct Entry {
  HostTime arrival;
  std::vector<sensor::Sample> samples;
};

struct Recording {
  sensor::Rig rig;
  std::vector<Entry> entries;  // By arrival.
  double ear_offset_s = 0;
  double ear_rate = 1;
  [[nodiscard]] DeviceTime ear_time(double t) const {
    return DeviceTime(from_seconds(ear_offset_s + ear_rate * t));
  }
  [[nodiscard]] double true_time(DeviceTime time) const {
    return (to_seconds(time.time_since_epoch()) - ear_offset_s) / ear_rate;
  }
};

/// `faces` sensors on the face and one behind the ear, all mounted anyhow. `skin` gives the skin's turn from
/// neutral (frame H) of sensor i at a time.
template <class Skin>
Recording record(const Script& script, const Faults& faults, std::size_t faces, std::uint64_t seed,
                 Skin&& skin, bool outward = false, bool positions = false) {
  Recording out;
  out.rig.name = "test";
  out.rig.reference = "ear";
  const double k = faults.scale;
  for (std::size_t s = 0; s <= faces; ++s) {
    const bool ear = s == faces;
    Random random = Random(seed).fork("sensor", s);
    sensor::Mount site;
    site.name = ear ? "ear" : "face" + std::to_string(s);
    site.kind = "imu";
    site.role = ear ? "head" : "face";
    const Quat mount = random.rotation();  // q_skin_sensor.
    if (outward && !ear) site.outward = mount.conjugate() * Vec3::UnitZ();

    const double offset_s = random.uniform(0, 100);
    const double rate = 1 + k * random.normal(0, 1e-6 * faults.clock_drift_ppm);
    if (ear) {
      out.ear_offset_s = offset_s;
      out.ear_rate = rate;
    }
    const auto draw = [&random](double sigma) {
      const double x = random.normal(), y = random.normal(), z = random.normal();
      return Vec3(sigma * Vec3(x, y, z));
    };
    Vec3 bias = draw(k * faults.gyro_bias_dps * kRadPerDeg);
    const Vec3 gyro_scale = Vec3::Ones() + draw(k * faults.gyro_scale);
    const Vec3 accel_bias = draw(k * faults.accel_bias_mg * 1e-3 * kStandardGravity_m_s2);
    const Vec3 accel_scale = Vec3::Ones() + draw(k * faults.accel_scale);
    // From the neck.
    const Vec3 arm =
        faults.arms *
        (ear ? Vec3(0.08, 0.11, 0.02) : Vec3{random.uniform(-0.06, 0.06), random.uniform(0.04, 0.18), 0.13});
    if (positions) site.position_m = arm;
    out.rig.sensors.push_back(site);
    const double gyro_sigma = k * faults.gyro_noise_dps_sqrt_hz * kRadPerDeg * std::sqrt(120.0);
    const double accel_sigma =
        k * faults.accel_noise_ug_sqrt_hz * 1e-6 * kStandardGravity_m_s2 * std::sqrt(120.0);
    const double walk = k * faults.gyro_bias_walk_dps_sqrt_min * kRadPerDeg / std::sqrt(240.0 * 60);
    const double slip_step = k * faults.slip_deg_per_sqrt_min * kRadPerDeg / std::sqrt(240.0 * 60);
    Vec3 slip = Vec3::Zero();
    constexpr double kStep = 1e-3;
    const auto orientation = [&](double t) {
      return Quat(script.head(t) * (ear ? Quat::Identity() : Quat(skin(s, t))) * exp_rotation(slip) * mount);
    };
    const auto position = [&](double t) { return Vec3(script.head(t) * arm); };
    std::uint32_t sequence = 0;
    for (double t = random.uniform(0, 0.016); t < script.end; ++sequence) {
      Entry entry;
      double sent = 0;
      for (int i = 0; i < 4; ++i, t += 1 / (240.0 * rate)) {
        bias += draw(walk);
        if (!ear) slip += draw(slip_step);
        const Quat q = orientation(t);
        const Vec3 gyro =
            log_rotation(orientation(t - kStep).conjugate() * orientation(t + kStep)) / (2 * kStep);
        const Vec3 accel = (position(t + kStep) - 2 * position(t) + position(t - kStep)) / (kStep * kStep);
        const Vec3 force = q.conjugate() * (accel + Vec3(0, kStandardGravity_m_s2, 0));
        const Vec3 g = gyro_scale.cwiseProduct(gyro) + bias + draw(gyro_sigma);
        const Vec3 f = accel_scale.cwiseProduct(force) + accel_bias + draw(accel_sigma);
        sensor::Sample sample;
        sample.sensor = static_cast<std::uint16_t>(s);
        sample.sequence = sequence;
        sample.time = DeviceTime(from_seconds(offset_s + rate * t));
        sample.count = 6;
        for (Eigen::Index a = 0; a < 3; ++a) {
          sample.values[static_cast<std::size_t>(a)] = static_cast<float>(g[a]);
          sample.values[static_cast<std::size_t>(a) + 3] = static_cast<float>(f[a]);
        }
        entry.samples.push_back(sample);
        sent = t;
      }
      entry.arrival = HostTime(from_seconds(sent + 0.001 + random.exponential(1e-3 * faults.radio_delay_ms)));
      if (!random.chance(k * faults.packet_loss)) out.entries.push_back(std::move(entry));
    }
  }
  std::ranges::sort(out.entries, {},
                    [](const Entry& e) { return std::pair(e.arrival, e.samples[0].sensor); });
  return out;
}

/// Plays a recording through tick rule and pipeline, which is told of no calibration step;
/// `seen(true time, frame, pipeline)` once a frame.
template <class Seen>
void play_unmarked(const Recording& recording, ClockedPipeline& pipeline, Seen&& seen) {
  sensor::TickRule ticks(recording.rig);
  model::FeatureFrame frame;
  const auto fire = [&](HostTime now) {
    while (const auto tick = ticks.due(now)) {
      pipeline.tick(tick->frame, frame);
      seen(recording.true_time(tick->frame), frame, pipeline);
    }
  };
  for (const Entry& entry : recording.entries) {
    fire(entry.arrival);
    for (const sensor::Sample& sample : entry.samples) {
      ticks.add(entry.arrival, sample);
      pipeline.add(entry.arrival, sample);
    }
    fire(entry.arrival);
  }
}

/// The same with the script's steps marked.
template <class Seen>
void play(const Recording& recording, const Script& script, ClockedPipeline& pipeline, Seen&& seen) {
  pipeline.mark(tracker::Step::neutral, recording.ear_time(0.05), recording.ear_time(3.0));
  pipeline.mark(tracker::Step::nod, recording.ear_time(script.nod_begin), recording.ear_time(script.nod_end));
  pipeline.mark(tracker::Step::shake, recording.ear_time(script.shake_begin),
                recording.ear_time(script.shake_end));
  play_unmarked(recording, pipeline, std::forward<Seen>(seen));
}

inline Quat rotation_of(const model::SensorFeature& feature) {
  return quat_of(feature.rotation);
}

}  // namespace mien::imu::testing_head
