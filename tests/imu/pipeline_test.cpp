#include "mien/imu/pipeline.h"

#include <gtest/gtest.h>

#include <array>
#include <iostream>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "mien/core/units.h"
#include "tests/imu/clocked_pipeline.h"
#include "tests/imu/nodding_head.h"

namespace mien::imu::pipeline_test {
namespace {

using testing_head::Entry;
using testing_head::Faults;
using testing_head::play;
using testing_head::record;
using testing_head::Recording;
using testing_head::rotation_of;
using testing_head::Script;
using testing_head::still_skin;

/// A skin that turns by up to 20 degrees about an axis of its own once the prologue is over, then rests at
/// neutral.
Quat moving_skin(std::size_t sensor, double t) {
  static const std::array<Vec3, 3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  const double on = testing_head::ease((t - 10) / 0.5) * (1 - testing_head::ease((t - 25) / 0.5));
  return exp_rotation(on * 20 * kRadPerDeg * std::sin(2.5 * t) * axes[sensor % 3]);
}

Faults no_faults() {
  Faults faults;
  faults.scale = 0;
  return faults;
}

// The promise of the device profile: a still face on a nodding and turning head reads as still.
TEST(Pipeline, AStillFaceOnAMovingHeadReadsStill) {
  const Script script;
  double sum = 0;
  double worst = 0;
  std::size_t count = 0;
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    const Recording recording = record(script, Faults{}, 11, seed, still_skin);
    testing_head::ClockedPipeline pipeline(recording.rig);
    std::array<double, 11> square{};
    std::array<std::size_t, 11> frames{};
    play(recording, script, pipeline,
         [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
           if (t < script.move_begin) return;
           for (std::size_t i = 0; i < 11; ++i) {
             if (!frame.sensors[i].has_rotation) continue;
             const double angle = log_rotation(rotation_of(frame.sensors[i])).norm();
             square[i] += angle * angle;
             ++frames[i];
           }
         });
    for (const sensor::Score& score : pipeline.calibration().scores) EXPECT_TRUE(score.pass) << score.name;
    for (std::size_t i = 0; i < 11; ++i) {
      EXPECT_GT(frames[i], 3500u);
      worst = std::max(worst, std::sqrt(square[i] / static_cast<double>(frames[i])) / kRadPerDeg);
      sum += square[i];
      count += frames[i];
    }
  }
  const double rms = std::sqrt(sum / static_cast<double>(count)) / kRadPerDeg;
  std::cout << "skin rotation of a still face: " << rms << " deg RMS, worst sensor " << worst << " deg\n";
  EXPECT_LT(rms, 1.5);
  EXPECT_LT(worst, 2.2);
}

TEST(Pipeline, ReadsTheSkinsOwnTurnInTheHeadsAxes) {
  Script script;
  script.end = 24;
  const Recording recording = record(script, no_faults(), 3, 21, moving_skin);
  testing_head::ClockedPipeline pipeline(recording.rig);
  std::size_t frames = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t < 10) return;
         ASSERT_TRUE(frame.has_head);
         EXPECT_LT(angle_between(frame.head, script.head(t)), 1.5 * kRadPerDeg) << t;
         for (std::size_t i = 0; i < 3; ++i)
           EXPECT_LT(angle_between(rotation_of(frame.sensors[i]), moving_skin(i, t)), 1.5 * kRadPerDeg)
               << i << " at " << t;
         ++frames;
       });
  EXPECT_GT(frames, 800u);
}

TEST(Pipeline, AMovingFaceDoesNotDragItsHeading) {
  Script script;
  script.end = 40;
  const Recording recording = record(script, Faults{}, 3, 22, moving_skin);
  testing_head::ClockedPipeline pipeline(recording.rig);
  double square = 0;
  std::size_t frames = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t < 10) return;
         for (std::size_t i = 0; i < 3; ++i) {
           const double error = angle_between(rotation_of(frame.sensors[i]), moving_skin(i, t));
           square += error * error;
           ++frames;
         }
       });
  EXPECT_LT(std::sqrt(square / static_cast<double>(frames)), 2.0 * kRadPerDeg);
}

TEST(Pipeline, ANodThatBeginsUpwardsTurnsNobodyRound) {
  Script script;
  script.end = 12;
  script.first_nod = -1;
  // The face's swing tells which way is ahead, whatever the rig says of outward axes.
  for (const int outward : {0, 1, -1}) {
    Recording recording = record(script, Faults{}, 3, 23, still_skin, outward != 0);
    for (sensor::Mount& mount : recording.rig.sensors)
      if (mount.outward) *mount.outward *= outward;
    testing_head::ClockedPipeline pipeline(recording.rig);
    std::size_t frames = 0;
    play(recording, script, pipeline,
         [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
           if (t < script.move_begin) return;
           EXPECT_LT(angle_between(frame.head, script.head(t)), 3 * kRadPerDeg) << outward << " at " << t;
           ++frames;
         });
    EXPECT_GT(frames, 100u);
    EXPECT_EQ(sensor::all_pass(pipeline.calibration().scores), outward >= 0);
  }
}

TEST(Pipeline, ANodOfWhichTheBeginningIsLostTurnsNobodyRound) {
  Script script;
  script.end = 12;
  Recording recording = record(script, Faults{}, 3, 23, still_skin);
  // Its first half cycle, from all sensors: what is heard first goes upwards.
  std::erase_if(recording.entries, [&](const Entry& entry) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    return t > script.nod_begin - 0.05 && t < script.nod_begin + 0.8;
  });
  testing_head::ClockedPipeline pipeline(recording.rig);
  std::size_t frames = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t < script.move_begin) return;
         EXPECT_LT(angle_between(frame.head, script.head(t)), 10 * kRadPerDeg) << t;
         ++frames;
       });
  EXPECT_GT(frames, 100u);
}

TEST(Pipeline, ARigWhoseHeadSensorIsAheadOfTheFaceIsBelieved) {
  Script script;
  script.end = 9;
  Recording recording = record(script, no_faults(), 3, 23, still_skin, false, true);
  testing_head::ClockedPipeline known(recording.rig);
  play(recording, script, known,
       [](double, const model::FeatureFrame&, const testing_head::ClockedPipeline&) {});
  for (sensor::Mount& mount : recording.rig.sensors) mount.position_m->z() *= -1;
  testing_head::ClockedPipeline turned(recording.rig);
  play(recording, script, turned,
       [](double, const model::FeatureFrame&, const testing_head::ClockedPipeline&) {});
  EXPECT_NEAR(angle_between(known.calibration().q_head_ear, turned.calibration().q_head_ear),
              std::numbers::pi, 1 * kRadPerDeg);
}

TEST(Pipeline, WithoutAccelerationsOutwardAxesOrTheNodsBeginningTellWhichWayIsAhead) {
  Script script;
  script.end = 12;
  std::optional<Quat> right;
  for (const double first_nod : {1.0, -1.0})
    for (const bool outward : {true, false}) {
      script.first_nod = first_nod;
      Faults at_the_neck = no_faults();
      at_the_neck.arms = 0;
      const Recording recording = record(script, at_the_neck, 3, 23, still_skin, outward);
      testing_head::ClockedPipeline pipeline(recording.rig);
      play(recording, script, pipeline,
           [](double, const model::FeatureFrame&, const testing_head::ClockedPipeline&) {});
      ASSERT_TRUE(pipeline.calibration().complete);
      const Quat found = pipeline.calibration().q_head_ear;
      if (!right) right = found;
      // Where nobody can know, pitch is taken for its opposite, left for right.
      const bool known = first_nod > 0 || outward;
      EXPECT_NEAR(angle_between(found, *right), known ? 0 : std::numbers::pi, 1 * kRadPerDeg);
      EXPECT_EQ(sensor::all_pass(pipeline.calibration().scores), first_nod > 0 || !outward);
    }
}

TEST(Pipeline, LeverArmsTakeTheHeadsTurningOutOfTheAcceleration) {
  Script script;
  script.end = 25;
  // Without the arms nobody knows what of a sensor's acceleration is the head's: there is none. With arms
  // that are nought it all stays; with the true ones it goes.
  Recording recording = record(script, no_faults(), 3, 24, still_skin, false, true);
  const sensor::Rig whole = recording.rig;
  const auto rms = [&](const std::optional<Vec3>& position) {
    for (std::size_t s = 0; s < whole.sensors.size(); ++s)
      recording.rig.sensors[s].position_m = position ? position : whole.sensors[s].position_m;
    double square = 0, count = 0;
    testing_head::ClockedPipeline pipeline(recording.rig);
    play(recording, script, pipeline,
         [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
           if (t < 12) return;
           for (const auto& feature : frame.sensors) {
             ASSERT_TRUE(feature.has_accel);
             square += feature.accel_m_s2.squaredNorm();
             ++count;
           }
         });
    return std::sqrt(square / count);
  };
  const double with_arms = rms(std::nullopt), without = rms(Vec3::Zero());
  EXPECT_LT(with_arms, 0.4 * without);
  EXPECT_LT(with_arms, 0.3);

  for (sensor::Mount& mount : recording.rig.sensors) mount.position_m.reset();
  testing_head::ClockedPipeline pipeline(recording.rig);
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t < 12) return;
         for (const auto& feature : frame.sensors) ASSERT_TRUE(feature.has_rotation && !feature.has_accel);
       });
}

TEST(Pipeline, SaysNothingBeforeACalibration) {
  Script script;
  script.end = 3;
  const Recording recording = record(script, Faults{}, 3, 25, still_skin);
  testing_head::ClockedPipeline pipeline(recording.rig);
  play(recording, script, pipeline,
       [&](double, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         EXPECT_FALSE(frame.has_head);
         ASSERT_EQ(frame.sensors.size(), 3u);
         for (const auto& feature : frame.sensors) {
           EXPECT_FALSE(feature.has_rotation);
           EXPECT_FALSE(feature.has_accel);
         }
       });
  EXPECT_FALSE(pipeline.calibration().complete);
}

TEST(Pipeline, AnotherBoardHasNoNeutralUntilTheNextCalibration) {
  Script script;
  script.end = 24;
  const Recording recording = record(script, Faults{}, 3, 26, still_skin);
  testing_head::ClockedPipeline pipeline(recording.rig);
  std::optional<Calibration> before;
  std::size_t seen = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, testing_head::ClockedPipeline& p) {
         if (t > 14 && !before) {
           before = p.calibration_now();
           EXPECT_TRUE(frame.sensors[1].has_rotation);
           p.forget(1);
           return;
         }
         if (t < 14.5) return;
         EXPECT_TRUE(frame.sensors[0].has_rotation);
         EXPECT_FALSE(frame.sensors[1].has_rotation);
         ++seen;
       });
  EXPECT_GT(seen, 300u);
  EXPECT_TRUE(pipeline.calibration().complete);
  ASSERT_TRUE(pipeline.restore(*before));  // A calibration gives it one again.
  EXPECT_TRUE(pipeline.calibration().sensors[1].valid);
  pipeline.forget(3);  // The ear's.
  EXPECT_FALSE(pipeline.calibration().complete);
}

TEST(Pipeline, TwoBoardsOfOneNumberSayNothing) {
  Script script;
  script.end = 16;
  Recording recording = record(script, no_faults(), 3, 27, moving_skin);
  // After the calibration the third's packets come under the second's number, too.
  std::vector<Entry> others = recording.entries;
  std::erase_if(others, [](const Entry& entry) {
    return entry.samples[0].sensor != 2 || to_seconds(entry.arrival.time_since_epoch()) < 12;
  });
  for (Entry& entry : others)
    for (sensor::Sample& sample : entry.samples) sample.sensor = 1;
  recording.entries.insert(recording.entries.end(), others.begin(), others.end());
  std::ranges::sort(recording.entries, {},
                    [](const Entry& entry) { return std::pair(entry.arrival, entry.samples[0].time); });
  testing_head::ClockedPipeline pipeline(recording.rig);
  std::size_t before = 0, shown = 0, frames = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t > 11 && t < 11.9) before += frame.sensors[1].has_rotation ? 1 : 0;
         if (t < 12.1) return;
         ++frames;
         shown += frame.sensors[1].has_rotation ? 1 : 0;
         EXPECT_TRUE(frame.sensors[0].has_rotation && frame.sensors[2].has_rotation) << t;
       });
  EXPECT_GT(before, 50u);
  EXPECT_GT(frames, 200u);
  EXPECT_EQ(shown, 0u);
}

TEST(Pipeline, ASensorIsLeftOutUntilItsHeadingIsKnownAgain) {
  Script script;
  script.end = 24;
  Recording recording = record(script, Faults{}, 3, 26, still_skin);
  // Sensor 1 is away for three seconds, long enough to have turned anywhere.
  std::erase_if(recording.entries, [](const Entry& entry) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    return entry.samples[0].sensor == 1 && t > 14 && t < 17;
  });
  testing_head::ClockedPipeline pipeline(recording.rig);
  const PipelineSettings settings;
  std::size_t unsure = 0, sure = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline& p) {
         if (t < 17.05) return;
         const SensorStatus status = p.status(1);
         EXPECT_EQ(frame.sensors[1].has_rotation,
                   std::hypot(status.heading_sigma_rad, status.tilt_sigma_rad) <= settings.unsure_rad)
             << t;
         EXPECT_LT(status.tilt_sigma_rad, 6 * kRadPerDeg) << "after a long gap gravity was asked anew";
         EXPECT_TRUE(frame.sensors[0].has_rotation);
         ++(frame.sensors[1].has_rotation ? sure : unsure);
       });
  EXPECT_GT(unsure, 0u);
  EXPECT_GT(sure, 300u);
}

TEST(Pipeline, ASensorThatCreepsIsFollowedAlsoBeyondItsBoardsRestart) {
  Script script;
  script.end = 160;
  constexpr double kCrept = 3 * kRadPerDeg;
  constexpr std::size_t kCreeper = 1;
  const auto creeping = [](std::size_t sensor, double t) {
    const double crept = sensor == kCreeper ? kCrept * std::clamp((t - 10) / 60, 0.0, 1.0) : 0;
    return exp_rotation(crept * Vec3::UnitX());
  };
  Recording recording = record(script, no_faults(), 3, 28, creeping);
  recording.rig.skin = sensor::SkinMotion{.sensors = recording.rig.face_sensor_names(),
                                          .mean_deg = Eigen::VectorXd::Zero(9),
                                          .factor_deg = 4 * Eigen::MatrixXd::Identity(9, 9)};
  for (Entry& entry : recording.entries)
    for (sensor::Sample& sample : entry.samples)
      if (sample.sensor == kCreeper && to_seconds(entry.arrival.time_since_epoch()) > 120)
        sample.time -= std::chrono::seconds(50);
  testing_head::ClockedPipeline pipeline(recording.rig);
  double before = 0, after = 0, tilt_sigma = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline& p) {
         const double shown = angle_between(rotation_of(frame.sensors[kCreeper]), Quat::Identity());
         if (t > 110 && t < 120) before = std::max(before, shown);
         if (t > 120) tilt_sigma = std::max(tilt_sigma, p.status(kCreeper).tilt_sigma_rad);
         if (t > 150) after = std::max(after, shown);
       });
  EXPECT_LT(before, kCrept / 2);
  EXPECT_LT(after, kCrept / 2);
  EXPECT_GT(tilt_sigma, 4 * kRadPerDeg) << "gravity was asked anew";
}

/// Frames 150 ms behind what was sent, by the clock models of a network without jitter, of samples that
/// arrive by another one; from a calibration on.
struct Heard {
  std::vector<model::FeatureFrame> frames;
  std::vector<SensorStatus> status;
};
Heard hear(const Recording& recording, const std::vector<Entry>& arrived, const Calibration& calibration) {
  Heard out;
  Pipeline pipeline(recording.rig);
  EXPECT_TRUE(pipeline.restore(calibration));
  sensor::TimeLines lines(recording.rig.sensors.size(), recording.rig.find(recording.rig.reference));
  std::size_t timed = 0, next = 0;
  for (double t = 0.5; t < 20; t += 1 / 60.0) {
    const HostTime now(from_seconds(t + 0.15));
    for (; timed < recording.entries.size() && recording.entries[timed].arrival <= now; ++timed)
      for (const sensor::Sample& sample : recording.entries[timed].samples)
        lines.add(recording.entries[timed].arrival, sample);
    for (; next < arrived.size() && arrived[next].arrival <= now; ++next)
      for (const sensor::Sample& sample : arrived[next].samples) pipeline.add(sample);
    pipeline.tick(recording.ear_time(t), lines, out.frames.emplace_back());
  }
  for (std::uint16_t s = 0; s < recording.rig.sensors.size(); ++s) out.status.push_back(pipeline.status(s));
  return out;
}

TEST(Pipeline, PacketsThatWereOvertakenAreIntegratedInTheirPlace) {
  Script script;
  script.end = 21;
  Faults faults;
  faults.packet_loss = 0;
  const Recording recording = record(script, faults, 3, 29, moving_skin);
  testing_head::ClockedPipeline calibrated(recording.rig);
  std::optional<Calibration> calibration;
  play(recording, script, calibrated,
       [&](double t, const model::FeatureFrame&, const testing_head::ClockedPipeline& p) {
         if (t > 10 && !calibration) calibration = p.calibration_now();
       });
  ASSERT_TRUE(calibration);

  std::vector<Entry> shuffled = recording.entries;
  Random random(30);
  for (Entry& entry : shuffled) entry.arrival += from_seconds(random.uniform(0, 0.1));
  std::ranges::sort(shuffled, {},
                    [](const Entry& entry) { return std::pair(entry.arrival, entry.samples[0].sensor); });
  // A tenth comes twice, the second time in its place or not.
  std::vector<Entry> doubled;
  for (const Entry& entry : shuffled) {
    if (random.chance(0.1)) doubled.push_back(entry);
    doubled.push_back(entry);
  }
  const Heard in_order = hear(recording, recording.entries, *calibration);
  const Heard late = hear(recording, doubled, *calibration);
  std::size_t same = 0;
  for (std::size_t f = 0; f < in_order.frames.size(); ++f) {
    const model::FeatureFrame& one = in_order.frames[f];
    const model::FeatureFrame& other = late.frames[f];
    ASSERT_EQ(one.head.coeffs(), other.head.coeffs()) << f;
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_EQ(one.sensors[i].has_rotation, other.sensors[i].has_rotation) << f;
      if (!one.sensors[i].has_rotation) continue;
      ASSERT_EQ(one.sensors[i].rotation, other.sensors[i].rotation) << f;
      ++same;
    }
  }
  EXPECT_GT(same, 3000u);
  for (std::uint16_t s = 0; s < 4; ++s) {
    EXPECT_LE(late.status[s].lost, 24u) << "of 4,800: those that have not come yet at the end";
    EXPECT_GT(late.status[s].dropped, 100u) << "those that came twice";
    EXPECT_EQ(late.status[s].heading_sigma_rad, in_order.status[s].heading_sigma_rad)
        << "a hole that was filled is no gap";
  }
}

TEST(Pipeline, AHeadingThatNoSkinCouldHaveIsFoundAnewAtOnce) {
  Script script;
  script.end = 16;
  // Half a second of shaking, of which a quarter is lost: at both of its ends the skin turns by 750 degrees a
  // second, and nobody knows that it came back between them.
  const auto shaken = [](std::size_t sensor, double t) {
    const double on = testing_head::ease((t - 11.5) / 0.25) * (1 - testing_head::ease((t - 12.5) / 0.25));
    const double turn = sensor == 0 ? on * 30 * kRadPerDeg * std::sin(8 * std::numbers::pi * (t - 12)) : 0;
    return exp_rotation(turn * Vec3::UnitY());
  };
  Recording recording = record(script, no_faults(), 3, 25, shaken);
  std::erase_if(recording.entries, [](const Entry& entry) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    return entry.samples.front().sensor == 0 && t > 12.0 && t < 12.27;
  });
  testing_head::ClockedPipeline pipeline(recording.rig);
  std::size_t frames = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t < 13.3 || !frame.sensors[0].has_rotation) return;
         EXPECT_LT(angle_between(rotation_of(frame.sensors[0]), Quat::Identity()), 12 * kRadPerDeg) << t;
         ++frames;
       });
  EXPECT_GT(frames, 100u);
}

TEST(Pipeline, NodesThatFuseEnterAfterTheFusion) {
  // Perfect fusions, each with a heading of its own, forty degrees apart.
  Script script;
  script.end = 20;
  Recording recording = record(script, no_faults(), 2, 28, still_skin);
  std::array<Quat, 3> mount;
  Random random(280);
  for (Quat& q : mount) q = random.rotation();
  // Without drift a device's time is true time and an offset; the earliest arrivals show it.
  std::array<double, 3> offset_s{};
  for (const Entry& entry : recording.entries) {
    const sensor::Sample& last = entry.samples.back();
    double& offset = offset_s[last.sensor];
    const double seen =
        to_seconds(last.time.time_since_epoch()) - to_seconds(entry.arrival.time_since_epoch()) + 0.001;
    offset = offset == 0 ? seen : std::max(offset, seen);
  }
  for (Entry& entry : recording.entries)
    for (sensor::Sample& sample : entry.samples) {
      const double t = to_seconds(sample.time.time_since_epoch()) - offset_s[sample.sensor];
      const Quat heading(Eigen::AngleAxisd(40 * kRadPerDeg * sample.sensor, Vec3::UnitY()));
      const Quat true_q =
          script.head(t) * (sample.sensor < 2 ? moving_skin(sample.sensor, t) : Quat::Identity());
      const Quat q = heading * true_q * mount[sample.sensor];
      const Vec3 force = (true_q * mount[sample.sensor]).conjugate() * Vec3(0, kStandardGravity_m_s2, 0);
      sample.kind = sensor::SampleKind::imu_fused;
      sample.count = 7;
      sample.values = {static_cast<float>(q.w()),     static_cast<float>(q.x()),
                       static_cast<float>(q.y()),     static_cast<float>(q.z()),
                       static_cast<float>(force.x()), static_cast<float>(force.y()),
                       static_cast<float>(force.z())};
    }
  testing_head::ClockedPipeline pipeline(recording.rig);
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
         if (t < 10) return;
         for (std::size_t i = 0; i < 2; ++i)
           EXPECT_LT(angle_between(rotation_of(frame.sensors[i]), moving_skin(i, t)), 1.0 * kRadPerDeg)
               << i << " at " << t;
       });
  // The headings are forty degrees apart, as far as the ear's axes tell: Z undoes what was put in.
  const double apart = std::remainder(
      pipeline.calibration().sensors[0].heading_rad - pipeline.calibration().sensors[1].heading_rad,
      2 * std::numbers::pi);
  EXPECT_NEAR(apart, 40 * kRadPerDeg, 0.5 * kRadPerDeg);
}

TEST(Pipeline, TheSameLogGivesTheSameBits) {
  Script script;
  script.end = 16;
  const Recording recording = record(script, Faults{}, 3, 29, moving_skin);
  std::vector<model::FeatureFrame> runs[2];
  for (auto& run : runs) {
    testing_head::ClockedPipeline pipeline(recording.rig);
    play(recording, script, pipeline,
         [&run](double, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
           run.push_back(frame);
         });
  }
  ASSERT_EQ(runs[0].size(), runs[1].size());
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(runs[0][i].sensors, runs[1][i].sensors);
    EXPECT_EQ(runs[0][i].head.coeffs(), runs[1][i].head.coeffs());
  }
}

TEST(Pipeline, DropsWhatComesTwiceOrLate) {
  Script script;
  script.end = 1;
  const Recording recording = record(script, Faults{}, 1, 30, still_skin);
  testing_head::ClockedPipeline pipeline(recording.rig);
  for (const Entry& entry : recording.entries)
    for (const sensor::Sample& sample : entry.samples) {
      pipeline.add(entry.arrival, sample);
      pipeline.add(entry.arrival, sample);
    }
  EXPECT_GT(pipeline.status(0).dropped, 200u);
  sensor::Sample bad = recording.entries[0].samples[0];
  bad.values[2] = std::numeric_limits<float>::quiet_NaN();
  pipeline.add(HostTime{}, bad);
  const auto dropped = pipeline.status(bad.sensor).dropped;
  bad.sensor = 99;
  pipeline.add(HostTime{}, bad);
  EXPECT_EQ(pipeline.status(recording.entries[0].samples[0].sensor).dropped, dropped);
}

}  // namespace
}  // namespace mien::imu::pipeline_test
