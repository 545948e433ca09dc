// What a live session would have seen of a virtual performer: its log, its ticks and its truth.
#include "mien/virtual/imu/imu_session.h"
#include "mien/core/units.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "mien/builtin_face/builtin_face.h"
#include "mien/imu/packets/packet.h"
#include "mien/imu/pipeline.h"
#include "mien/performer/performer.h"
#include "mien/performer/style.h"
#include "tests/imu/clocked_pipeline.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::imu_session_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

performer::PrologueMotion bare(const face::Motion& motion) {
  return performer::with_prologue(motion, performer::PrologueKind::none, Random(3));
}
performer::PrologueMotion brief(const face::Motion& motion, bool gestures = true) {
  return performer::with_prologue(motion, performer::PrologueKind::brief, Random(3), {.gestures = gestures});
}

VirtualSession devices(const performer::PrologueMotion& motion, std::uint64_t seed = 11,
                       const DeviceFaults& faults = test::mild_faults()) {
  return play_devices(motion, test::three_sites(), test::three_sensors(), faults, Random(seed)).value();
}
VirtualSession lab(const performer::PrologueMotion& motion, std::uint64_t seed = 11,
                   double noise_rad = kLabNoiseRad) {
  return play_lab(motion, test::three_sites(), test::three_sensors(), Random(seed), noise_rad).value();
}

std::vector<std::string> kinds(const VirtualSession& session) {
  std::vector<std::string> kinds;
  for (const take::Event& event : session.events) kinds.push_back(event.kind);
  return kinds;
}

/// What holds of every session, whatever was played.
void expect_sound(const VirtualSession& session) {
  ASSERT_FALSE(session.entries.empty());
  ASSERT_FALSE(session.ticks.empty());
  for (std::size_t i = 0; i < session.entries.size(); ++i) {
    EXPECT_EQ(session.entries[i].id, static_cast<std::int64_t>(i) + 1);
    if (i > 0) {
      EXPECT_LE(session.entries[i - 1].arrival, session.entries[i].arrival);
    }
  }
  // Samples are what the packets say, in the packets' order, and nothing else.
  std::vector<sensor::Sample> decoded;
  std::size_t next = 0;
  for (const take::LogEntry& entry : session.entries) {
    const auto packet = imu::parse_packet(entry.bytes);
    ASSERT_TRUE(packet) << packet.error().message();
    EXPECT_EQ(imu::encode_packet(*packet).value(), entry.bytes);
    decoded.clear();
    imu::append_samples(*packet, static_cast<std::uint16_t>(packet->device & 0xFFU), decoded);
    for (const sensor::Sample& sample : decoded) {
      ASSERT_LT(next, session.samples.size());
      const take::StoredSample& stored = session.samples[next++];
      EXPECT_EQ(stored.entry, entry.id);
      EXPECT_EQ(stored.arrival, entry.arrival);
      EXPECT_EQ(stored.sample.sensor, sample.sensor);
      EXPECT_EQ(stored.sample.sequence, sample.sequence);
      EXPECT_EQ(stored.sample.time, sample.time);
      EXPECT_EQ(stored.sample.values, sample.values);
    }
  }
  EXPECT_EQ(next, session.samples.size());
  // Ticks stand on the grid without a hole, one truth each.
  ASSERT_EQ(session.truth.size(), session.ticks.size());
  const auto count = static_cast<std::int64_t>(session.entries.size());
  for (std::size_t i = 0; i < session.ticks.size(); ++i) {
    const take::Tick& tick = session.ticks[i];
    EXPECT_EQ(tick.frame, DeviceTime(frame_offset(tick.index)));
    EXPECT_EQ(tick.index, session.ticks[0].index + static_cast<std::int64_t>(i));
    EXPECT_EQ(session.truth[i].time, tick.frame);
    ASSERT_GE(tick.after_entry, i == 0 ? 0 : session.ticks[i - 1].after_entry);
    ASSERT_LE(tick.after_entry, count);
    // Nothing was known at a tick that arrived after it.
    if (tick.after_entry > 0) {
      EXPECT_LE(session.entries[static_cast<std::size_t>(tick.after_entry) - 1].arrival, tick.fired);
    }
    if (tick.after_entry < count) {
      EXPECT_GE(session.entries[static_cast<std::size_t>(tick.after_entry)].arrival, tick.fired);
    }
  }
  for (std::size_t i = 0; i < session.events.size(); ++i) {
    EXPECT_LT(session.events[i].begin, session.events[i].end);
    if (i > 0) {
      EXPECT_GE(session.events[i].begin, session.events[i - 1].begin);
    }
  }
}

TEST(DeviceSession, IsSound) {
  expect_sound(devices(brief(test::talking(90))));
}

TEST(LabSession, IsSound) {
  expect_sound(lab(brief(test::talking(90, false), false)));
}

TEST(DeviceSession, LateAndLostPacketsLeaveItSound) {
  DeviceFaults faults = test::mild_faults();
  faults.radio_delay_ms = 40;  // Packets overtake one another.
  faults.packet_loss = 0.2;
  const VirtualSession session = devices(bare(test::talking(180)), 11, faults);
  expect_sound(session);
  const VirtualSession whole = devices(bare(test::talking(180)), 11, test::mild_faults());
  EXPECT_NEAR(static_cast<double>(session.entries.size()), 0.8 * static_cast<double>(whole.entries.size()),
              0.06 * static_cast<double>(whole.entries.size()));
}

TEST(DeviceSession, TheSeedDecidesEveryByte) {
  const performer::PrologueMotion motion = bare(test::talking(60));
  const VirtualSession one = devices(motion, 11);
  const VirtualSession same = devices(motion, 11);
  const VirtualSession other = devices(motion, 12);
  ASSERT_EQ(one.entries.size(), same.entries.size());
  for (std::size_t i = 0; i < one.entries.size(); ++i) {
    EXPECT_EQ(one.entries[i].bytes, same.entries[i].bytes);
    EXPECT_EQ(one.entries[i].arrival, same.entries[i].arrival);
  }
  ASSERT_EQ(one.ticks.size(), same.ticks.size());
  for (std::size_t i = 0; i < one.ticks.size(); ++i) EXPECT_EQ(one.ticks[i].fired, same.ticks[i].fired);
  std::size_t different = 0;
  for (std::size_t i = 0; i < std::min(one.entries.size(), other.entries.size()); ++i)
    different += one.entries[i].bytes != other.entries[i].bytes ? 1 : 0;
  EXPECT_GT(different, one.entries.size() / 2);
}

TEST(LabSession, TheSeedDecidesEveryByte) {
  const performer::PrologueMotion motion = bare(test::talking(60, false));
  const VirtualSession one = lab(motion, 11);
  const VirtualSession same = lab(motion, 11);
  const VirtualSession other = lab(motion, 12);
  ASSERT_EQ(one.entries.size(), same.entries.size());
  ASSERT_EQ(one.entries.size(), other.entries.size());
  for (std::size_t i = 0; i < one.entries.size(); ++i) {
    EXPECT_EQ(one.entries[i].bytes, same.entries[i].bytes);
    EXPECT_NE(one.entries[i].bytes, other.entries[i].bytes);
  }
}

TEST(DeviceSession, EventsComeInTheirOrder) {
  EXPECT_THAT(kinds(devices(brief(test::talking(30)))), ElementsAre("neutral", "nod", "shake", "ease"));
  EXPECT_TRUE(kinds(devices(bare(test::talking(30)))).empty());
}

TEST(LabSession, HasNoGesturesAmongItsEvents) {
  EXPECT_THAT(kinds(lab(brief(test::talking(30, false), false))), ElementsAre("neutral", "ease"));
}

TEST(DeviceSession, PromptsTellWhatWasAskedFor) {
  const VirtualSession session = lab(performer::with_prologue(
      test::talking(30, false), performer::PrologueKind::full, Random(3), {.gestures = false}));
  std::size_t prompts = 0;
  for (const take::Event& event : session.events) {
    if (event.kind != "prompt") continue;
    ++prompts;
    EXPECT_THAT(event.json, HasSubstr("\"target\": {\""));
    EXPECT_THAT(event.json, HasSubstr("\"anchor\": "));
  }
  EXPECT_GT(prompts, 10U);
}

/// The face is still in every event but the ease, whose end is where the frames that count begin.
void expect_quiet_prologue(const VirtualSession& session) {
  std::size_t quiet = 0;
  std::size_t counted = 0;
  for (const take::TruthFrame& truth : session.truth) {
    for (const take::Event& event : session.events) {
      const bool within = truth.time >= event.begin && truth.time < event.end;
      if (within) {
        EXPECT_FALSE(truth.evaluated) << event.kind;
      }
      if (within && event.kind != "ease") {
        EXPECT_EQ(truth.weights, face::BlendshapeWeights{}) << event.kind;
        ++quiet;
      }
    }
    if (truth.time > session.events.back().end + std::chrono::milliseconds(1)) {
      EXPECT_TRUE(truth.evaluated || truth.time > session.truth.back().time - std::chrono::milliseconds(300));
    }
    counted += truth.evaluated ? 1 : 0;
  }
  EXPECT_GT(quiet, 170U);  // Three seconds of neutral at least.
  EXPECT_NEAR(static_cast<double>(counted), 90, 1);
}

TEST(DeviceSession, ThePrologueIsNeutralAndDoesNotCount) {
  expect_quiet_prologue(devices(brief(test::talking(90))));
}

TEST(LabSession, ThePrologueIsNeutralAndDoesNotCount) {
  expect_quiet_prologue(lab(brief(test::talking(90, false), false)));
}

TEST(LabSession, EveryFrameOfTheMotionCounts) {
  // All lengths: the last frame must not be lost to a rounding of its time.
  for (int frames = 1; frames <= 130; ++frames) {
    const face::Motion motion = test::talking(frames, false);
    const VirtualSession session = lab(bare(motion));
    ASSERT_EQ(session.ticks.size(), static_cast<std::size_t>(frames));
    for (std::size_t i = 0; i < session.truth.size(); ++i) {
      ASSERT_TRUE(session.truth[i].evaluated) << i << " of " << frames;
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        ASSERT_NEAR(session.truth[i].weights[k], motion.frames[i].weights[k], 1e-5);
    }
  }
}

TEST(LabSession, CarriesOneNoisyRotationASensorAndFrame) {
  face::Motion still = test::talking(300, false);
  for (face::MotionFrame& frame : still.frames) frame.weights = {};
  const VirtualSession session = lab(bare(still));
  EXPECT_EQ(session.samples.size(), 2U * 300U);
  double square = 0;
  for (const take::StoredSample& stored : session.samples) {
    EXPECT_EQ(stored.sample.kind, sensor::SampleKind::imu_head_relative);
    EXPECT_LT(stored.sample.sensor, 2);  // Never the ear's.
    ASSERT_EQ(stored.sample.count, 3);
    for (const float value : stored.sample.used()) square += value * value;
  }
  EXPECT_NEAR(std::sqrt(square / (3.0 * static_cast<double>(session.samples.size()))), 1.0 * kRadPerDeg,
              0.08 * kRadPerDeg);
}

TEST(LabSession, WithoutNoiseItIsTheSkinsOwnTurn) {
  const auto sites = test::three_sites();
  const VirtualSession session = lab(bare(test::talking(60, false)), 1, 0);
  for (const take::StoredSample& stored : session.samples) {
    const auto frame = static_cast<std::size_t>(stored.sample.sequence);
    const Vec3 expected = log_rotation(sites[stored.sample.sensor].rotation(session.truth[frame].weights));
    for (std::size_t axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(stored.sample.values[axis], expected[static_cast<Eigen::Index>(axis)], 1e-6);
  }
}

TEST(Sessions, RefuseAMotionWithoutFrames) {
  performer::PrologueMotion empty;
  empty.motion.name = "nothing.csv";
  for (const auto& session :
       {play_devices(empty, test::three_sites(), test::three_sensors(), DeviceFaults{}, Random(1)),
        play_lab(empty, test::three_sites(), test::three_sensors(), Random(1))}) {
    ASSERT_FALSE(session);
    EXPECT_EQ(session.error().code, ErrorCode::bad_usage);
    EXPECT_THAT(session.error().message(), HasSubstr("nothing.csv"));
  }
}

TEST(DeviceSession, SensorsFallSilentForSecondsWhenTheFaultsSayTheyDo) {
  DeviceFaults faults = test::mild_faults();
  const auto longest_gap = [&] {
    const VirtualSession session = devices(bare(test::talking(600)), 5, faults);
    std::array<HostTime, 3> last{};
    Duration longest{};
    for (const take::StoredSample& stored : session.samples) {
      if (last[stored.sample.sensor] != HostTime{})
        longest = std::max(longest, stored.arrival - last[stored.sample.sensor]);
      last[stored.sample.sensor] = stored.arrival;
    }
    return longest;
  };
  EXPECT_LT(longest_gap(), std::chrono::milliseconds(100));
  faults.sensor_loss_per_hour = 720;  // One in five seconds.
  EXPECT_GT(longest_gap(), std::chrono::milliseconds(900));
}

/// Ten seconds of a performer on the built-in face with the default rig and all of its faults.
struct Performance {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  DeviceFaults faults = parse_faults(rig.faults_toml, "default rig").value();
  std::vector<SkinSite> sites = skin_sites(builtin_face::make_builtin(), rig).value();
  performer::PrologueMotion motion;

  Performance() {
    Random style_random(71);
    const performer::Style style = performer::draw_style(style_random);
    motion =
        brief(performer::perform(performer::default_script(performer::Block::mixed, 10), style, Random(72)));
  }
  static const Performance& get() {
    static const Performance performance;
    return performance;
  }
};

using ReceivedTest = std::function<bool(const take::StoredSample&)>;

/// Solves a session as a live one does, but for the samples that were not heard. Calls `see` with every frame
/// that counts.
void solve(const VirtualSession& session, const ReceivedTest& received,
           const std::function<void(const take::TruthFrame&, const model::FeatureFrame&)>& see) {
  imu::testing_head::ClockedPipeline pipeline(Performance::get().rig);
  for (const take::Event& event : session.events) {
    pipeline.mark(tracker::step_named(event.kind), event.begin, event.end);
  }
  model::FeatureFrame frame;
  auto next = session.samples.begin();
  for (std::size_t i = 0; i < session.ticks.size(); ++i) {
    for (; next != session.samples.end() && next->entry <= session.ticks[i].after_entry; ++next)
      if (received(*next)) pipeline.add(next->arrival, next->sample);
    pipeline.tick(session.ticks[i].frame, frame);
    const take::TruthFrame& truth = session.truth[i];
    if (truth.evaluated) see(truth, frame);
  }
}

/// Pooled over the face's sensors, degrees; `missing` is the share of rotations that are not there.
struct Error {
  double rms_deg = 0;
  double missing = 0;
};

Error skin_error(const VirtualSession& session, const ReceivedTest& received) {
  const std::vector<std::uint16_t> face_sensors = Performance::get().rig.face_sensors();
  double square = 0;
  double there = 0;
  double all = 0;
  solve(session, received, [&](const take::TruthFrame& truth, const model::FeatureFrame& frame) {
    for (std::size_t s = 0; s < face_sensors.size(); ++s) {
      ++all;
      if (!frame.sensors[s].has_rotation) continue;
      ++there;
      const auto& q = frame.sensors[s].rotation;
      const Quat skin = Performance::get().sites[face_sensors[s]].rotation(truth.weights);
      const double angle = skin.angularDistance(Quat(q[0], q[1], q[2], q[3]));
      square += angle * angle;
    }
  });
  return {std::sqrt(square / std::max(1.0, there)) / kRadPerDeg, 1 - there / all};
}

bool hear_all(const take::StoredSample&) {
  return true;
}

TEST(DeviceSession, ThePipelineFindsTheSkinAgain) {
  const Performance& p = Performance::get();
  const VirtualSession session = play_devices(p.motion, p.sites, p.rig, p.faults, Random(73)).value();
  const Error error = skin_error(session, hear_all);
  RecordProperty("rms_deg", std::to_string(error.rms_deg));
  EXPECT_LT(error.rms_deg, 2.5);
  EXPECT_LT(error.missing, 0.001);
}

TEST(DeviceSession, ThePipelineSurvivesLostPackets) {
  const Performance& p = Performance::get();
  DeviceFaults faults = p.faults;
  faults.packet_loss = 0.05;
  const VirtualSession session = play_devices(p.motion, p.sites, p.rig, faults, Random(73)).value();
  const Error error = skin_error(session, hear_all);
  RecordProperty("rms_deg", std::to_string(error.rms_deg));
  EXPECT_LT(error.rms_deg, 2.5);
  EXPECT_LT(error.missing, 0.01);
}

TEST(DeviceSession, ASilentSensorIsMissingAndTheOthersAreNot) {
  const Performance& p = Performance::get();
  const VirtualSession session = play_devices(p.motion, p.sites, p.rig, p.faults, Random(73)).value();
  const std::vector<std::uint16_t> face_sensors = p.rig.face_sensors();
  const std::uint16_t silent = face_sensors[3];
  const HostTime from(from_seconds(p.motion.times.motion_start_s + 3));
  const HostTime until = from + std::chrono::seconds(3);
  std::size_t missing = 0;
  std::size_t before = 0;
  std::size_t tick = 0;
  while (!session.truth[tick].evaluated) ++tick;
  solve(
      session,
      [&](const take::StoredSample& stored) {
        return stored.sample.sensor != silent || stored.arrival < from || stored.arrival >= until;
      },
      [&](const take::TruthFrame&, const model::FeatureFrame& frame) {
        const HostTime now = session.ticks[tick++].fired;
        if (now < from) before += frame.sensors[3].has_rotation ? 1 : 0;
        if (now > from + std::chrono::milliseconds(150) && now < until) {
          EXPECT_FALSE(frame.sensors[3].has_rotation) << to_seconds(now - from) << " s into the silence";
          ++missing;
        }
        for (std::size_t s = 0; s < face_sensors.size(); ++s)
          if (s != 3) {
            EXPECT_TRUE(frame.sensors[s].has_rotation) << p.rig.sensors[face_sensors[s]].name;
          }
      });
  EXPECT_GT(before, 170U);
  EXPECT_GT(missing, 165U);
}

}  // namespace
}  // namespace mien::virt::imu_session_test
