// Microphones beside a performer's sensors: into a take, and on the network.
#include "mien/virtual/speech/worn_microphones.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "mien/core/files.h"
#include "mien/speech/sound_block.h"
#include "mien/virtual/node_group.h"
#include "mien/virtual/perform_take.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::worn_microphones_test {
namespace {

using ::testing::HasSubstr;

std::string microphone(const std::string& name, const std::string& device) {
  return "[[sensor]]\nname = \"" + name + "\"\nkind = \"speech\"\nrole = \"face\"\ndevice = \"" + device +
         "\"\n";
}
const std::string kOne = microphone("microphone", "02:4D:49:53:4E:01");
const std::string kOther = microphone("other", "02:4D:49:53:4E:02");
/// The three sensors, bound as a rig that binds none means them.
std::string three_bound() {
  std::string rig = test::kRig;
  const std::string at = "[[sensor]]\n";
  std::size_t from = 0;
  for (int s = 0; s < 3; ++s) {
    from = rig.find(at, from) + at.size();
    rig.insert(from, "device = \"02:4D:49:45:4E:0" + std::to_string(s) + "\"\n");
  }
  return rig;
}
const std::string kFaults =
    "[faults]\nclock_offset_s = [1, 50]\nclock_drift_ppm = 20\nradio_delay_min_ms = 1\nradio_delay_ms = 3\n"
    "packet_loss = 0.05\n";
const std::string kMicrophoneFaults =
    "[faults.microphone]\nclock_offset_s = [1, 50]\nclock_drift_ppm = 100\nradio_delay_min_ms = 20\n"
    "radio_delay_ms = 2\npacket_loss = 0.02\nnoise = 0.0003\n";

/// A second and a half of a tone.
Sound tone() {
  Sound sound{.rate_hz = 16'000, .samples = std::vector<float>(24'000)};
  for (std::size_t i = 0; i < sound.samples.size(); ++i)
    sound.samples[i] =
        static_cast<float>(0.5 * std::sin(2 * std::numbers::pi * 300 * static_cast<double>(i) / 16'000));
  return sound;
}

class WornMicrophone : public ::testing::Test {
 protected:
  void SetUp() override {
    request_.motion = test::talking(91);
    request_.sound = tone();
    request_.seed = 5;
  }
  const StageRequest& with_rig(const std::string& toml) {
    EXPECT_TRUE(write_file(folder_ / "rig.toml", toml));
    request_.rig = folder_ / "rig.toml";
    return request_;
  }
  Error refused(const std::string& toml) {
    const auto stage = set_stage(with_rig(toml));
    EXPECT_FALSE(stage);
    return stage ? Error{} : stage.error();
  }
  mien::test::Folder folder_;
  StageRequest request_;
};

std::vector<take::LogEntry> sound_of(const VirtualSession& session, bool sound = true) {
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : session.entries)
    if (speech::is_packet(entry.bytes) == sound) entries.push_back(entry);
  return entries;
}

std::vector<take::StoredSample> samples_of(const VirtualSession& session, std::uint16_t sensor) {
  std::vector<take::StoredSample> samples;
  for (const take::StoredSample& stored : session.samples)
    if (stored.sample.sensor == sensor) samples.push_back(stored);
  return samples;
}

TEST_F(WornMicrophone, HearsThePerformanceBesideTheSensors) {
  const Stage stage = set_stage(with_rig(three_bound() + kOne + kFaults + kMicrophoneFaults)).value();
  const VirtualSession session = play(stage).value();
  const double seconds = stage.motion.motion.duration_s() + 2 * kDeviceMarginS;
  EXPECT_NEAR(static_cast<double>(sound_of(session).size()), 50 * seconds * 0.98, 12);
  const std::vector<take::StoredSample> heard = samples_of(session, 3);
  ASSERT_EQ(heard.size(), sound_of(session).size());
  // The tone begins with the motion, and is heard at its end.
  const HostTime begins{from_seconds(stage.motion.times.motion_start_s)};
  std::size_t loud = 0;
  for (const take::StoredSample& block : heard) {
    EXPECT_EQ(block.sample.kind, sensor::SampleKind::sound);
    const double since_s = to_seconds(block.arrival - begins);
    if (since_s < 0.02) {
      EXPECT_LT(block.sample.values[0], 0.001F);
    } else if (since_s > 0.08 && since_s < 1.5) {
      EXPECT_NEAR(block.sample.values[0], 0.5 / std::numbers::sqrt2, 0.02);
      ++loud;
    }
  }
  EXPECT_GT(loud, 60U);
  EXPECT_EQ(session.truth.size(), session.ticks.size());
}

TEST_F(WornMicrophone, LeavesTheSensorsAsTheyAre) {
  const VirtualSession without = play(set_stage(with_rig(three_bound() + kFaults)).value()).value();
  const VirtualSession with =
      play(set_stage(with_rig(three_bound() + kOne + kFaults + kMicrophoneFaults)).value()).value();
  const std::vector<take::LogEntry> sensors = sound_of(with, false);
  ASSERT_EQ(sensors.size(), without.entries.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    ASSERT_EQ(sensors[i].bytes, without.entries[i].bytes);
    ASSERT_EQ(sensors[i].arrival, without.entries[i].arrival);
  }
  EXPECT_EQ(with.motion_start, without.motion_start);
}

TEST_F(WornMicrophone, OfTwoEachHasAClockOfItsOwn) {
  const Stage stage =
      set_stage(with_rig(three_bound() + kOne + kOther + kFaults + kMicrophoneFaults)).value();
  const VirtualSession session = play(stage).value();
  const auto one = samples_of(session, 3), other = samples_of(session, 4);
  EXPECT_GT(one.size(), 150U);
  EXPECT_GT(other.size(), 150U);
  EXPECT_GT(std::chrono::abs(one.front().sample.time - other.front().sample.time),
            std::chrono::milliseconds(100));
}

TEST_F(WornMicrophone, IsWornAloneToo) {
  const Stage stage = set_stage(with_rig("name = \"ear\"\nreference = \"microphone\"\n" + kOne)).value();
  const VirtualSession session = play(stage).value();
  EXPECT_EQ(sound_of(session).size(), session.entries.size());
  EXPECT_GT(session.ticks.size(), 100U);
  ASSERT_EQ(session.truth.size(), session.ticks.size());
  EXPECT_TRUE(std::ranges::any_of(session.truth, &take::TruthFrame::evaluated));
}

TEST_F(WornMicrophone, InTheProfileLabItIsPerfect) {
  request_.devices = "lab";
  const Stage stage = set_stage(with_rig(three_bound() + kOne + kFaults + kMicrophoneFaults)).value();
  const VirtualSession session = play(stage).value();
  const auto heard = samples_of(session, 3);
  ASSERT_GT(heard.size(), 50U);
  for (std::size_t b = 0; b < heard.size(); ++b)
    EXPECT_EQ(heard[b].sample.sequence, b) << "none is lost, and its clock begins with the session";
  for (std::size_t i = 1; i < session.entries.size(); ++i)
    ASSERT_GE(session.entries[i].arrival, session.entries[i - 1].arrival);
}

TEST_F(WornMicrophone, WithoutSoundHearsAQuietRoom) {
  request_.sound.reset();
  const VirtualSession session =
      play(set_stage(with_rig(three_bound() + kOne + kFaults + kMicrophoneFaults)).value()).value();
  const auto heard = samples_of(session, 3);
  ASSERT_GT(heard.size(), 150U);
  for (const take::StoredSample& block : heard) {
    ASSERT_GT(block.sample.values[0], 0);
    ASSERT_LT(block.sample.values[0], 0.001F);
  }
}

TEST_F(WornMicrophone, TheShippedRigIsWorn) {
  request_.rig = project_path("rigs/imu_microphone.toml");
  request_.motion = test::talking(10);
  const VirtualSession session = play(set_stage(request_).value()).value();
  EXPECT_GT(sound_of(session).size(), 200U);
}

TEST_F(WornMicrophone, ATakeHoldsItsBlocks) {
  PerformRequest request;
  static_cast<StageRequest&>(request) = with_rig(three_bound() + kOne + kFaults + kMicrophoneFaults);
  request.take = folder_ / "a.mien";
  ASSERT_TRUE(perform_take(request, no_progress));
  const take::Take take = take::Take::open(request.take).value();
  EXPECT_TRUE(take.check());
  std::size_t blocks = 0;
  const std::vector<take::LogEntry> entries = take.entries().value();
  for (const take::LogEntry& entry : entries) blocks += speech::logged_block(entry.bytes, {}) ? 1 : 0;
  EXPECT_GT(blocks, 200U);
  EXPECT_EQ(take.audio().value()->rate_hz, 16'000) << "what was said, as truth";
}

TEST_F(WornMicrophone, SaysOnTheNetworkWhatATakeOfTheSamePerformanceHolds) {
  with_rig(three_bound() + kOne + kOther + kFaults + kMicrophoneFaults);
  const VirtualSession session = play(set_stage(request_).value()).value();
  const auto group = NodeGroup::create(set_stage(request_).value(), NodeLanguage::mien, false).value();
  NodeGroup& nodes = *group;
  ASSERT_EQ(nodes.size(), 5U);
  EXPECT_FALSE(nodes[3].listens());
  std::multimap<std::vector<std::byte>, HostTime> said;
  nodes.begin(HostTime());
  for (double t = -0.3; t < 20 && !nodes.finished(); t += 0.001) {
    while (nodes.simulated_s() < t) ASSERT_TRUE(nodes.simulate());
    for (std::size_t n = 0; n < nodes.size(); ++n)
      while (auto datagram = nodes[n].next_datagram(HostTime(from_seconds(t))))
        if (speech::is_packet(*datagram)) said.emplace(*std::move(datagram), HostTime(from_seconds(t)));
  }
  EXPECT_TRUE(nodes.finished());
  const std::vector<take::LogEntry> blocks = sound_of(session);
  for (const take::LogEntry& entry : blocks) {
    const auto found = said.find(entry.bytes);
    ASSERT_NE(found, said.end());
    EXPECT_GE(found->second, entry.arrival);
    EXPECT_LE(found->second, entry.arrival + std::chrono::microseconds(1'001));
  }
  EXPECT_NEAR(static_cast<double>(said.size()), static_cast<double>(blocks.size()), 2);
}

TEST_F(WornMicrophone, GoesOnWhereThePerformanceIsToldTo) {
  with_rig(three_bound() + kOne);
  const auto group = NodeGroup::create(set_stage(request_).value(), NodeLanguage::mien, true).value();
  NodeGroup& nodes = *group;
  nodes.begin(HostTime());
  std::map<std::size_t, std::size_t> loud;  // Blocks of the tone by round.
  for (double t = -0.3; t < 30; t += 0.005) {
    while (nodes.simulated_s() < t) ASSERT_TRUE(nodes.simulate());
    while (auto datagram = nodes[3].next_datagram(HostTime(from_seconds(t)))) {
      const auto block = speech::samples_of(speech::parse_packet(*datagram)->samples).value();
      if (speech::loudness_of(block).rms > 0.1F) ++loud[nodes.round_at(t - 0.01).number];
    }
  }
  EXPECT_FALSE(nodes.finished());
  ASSERT_GT(loud.size(), 5U);
  for (const auto& [round, blocks] : loud)
    if (round < loud.rbegin()->first) {
      EXPECT_NEAR(static_cast<double>(blocks), 75, 3) << round;
    }
}

TEST_F(WornMicrophone, RefusesWhatCannotBe) {
  Error error = refused(three_bound() + microphone("mine", "02:4D:49:53:4E:00") + kFaults);
  EXPECT_EQ(error.code, ErrorCode::bad_usage);
  EXPECT_THAT(error.message(), HasSubstr("02:4D:49:53:4E:01")) << "what to do";
  error = refused(three_bound() + microphone("mine", "02:4D:49:53:4E:01/2"));
  EXPECT_EQ(error.code, ErrorCode::bad_usage);
  std::string rig = three_bound();
  rig.replace(rig.find("mastoid_L"), 9, "microphone");
  error = refused(rig + kOne);
  EXPECT_EQ(error.code, ErrorCode::bad_usage);
  EXPECT_THAT(error.message(), HasSubstr("reference"));
  error = refused(three_bound() + kOne + kFaults + "[faults.microphone]\ngyro_scale = 1\n");
  EXPECT_EQ(error.code, ErrorCode::malformed);
  EXPECT_THAT(error.message(), HasSubstr("gyro_scale"));
  EXPECT_EQ(refused(three_bound() + kOne + "[faults]\nmicrophone = 3\n").code, ErrorCode::malformed);
  EXPECT_EQ(refused(three_bound() + kOne + "[faults]\nnoise = 0.1\n").code, ErrorCode::malformed)
      << "the microphone's own table is for that";
  request_.sound->rate_hz = 1;
  EXPECT_EQ(refused(three_bound() + kOne).code, ErrorCode::out_of_range);
  request_.sound = tone();
  with_rig(three_bound() + kOne);
  const auto slimevr = NodeGroup::create(set_stage(request_).value(), NodeLanguage::slimevr, false);
  ASSERT_FALSE(slimevr);
  EXPECT_EQ(slimevr.error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::virt::worn_microphones_test
