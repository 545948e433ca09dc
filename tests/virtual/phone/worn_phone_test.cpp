// A phone that looks on beside a performer's sensors: into a take, and on the network.
#include "mien/virtual/phone/worn_phone.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "mien/core/files.h"
#include "mien/imu/imu_tracker.h"
#include "mien/phone/inner_face.h"
#include "mien/phone/live_link.h"
#include "mien/sensor/bindings.h"
#include "mien/sensor/rig_part.h"
#include "mien/virtual/node_group.h"
#include "mien/virtual/perform_take.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/session/session_run.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::worn_phone_test {
namespace {

using ::testing::HasSubstr;

std::string phone(const std::string& name, const std::string& role,
                  const std::string& device = "02:4D:49:50:48:00") {
  return "[[sensor]]\nname = \"" + name + "\"\nkind = \"weights\"\nrole = \"" + role + "\"\ndevice = \"" +
         device + "\"\n";
}
const std::string kTruth = phone("phone", "truth");
const std::string kFaults =
    "[faults]\nclock_offset_s = [1, 50]\nclock_drift_ppm = 20\nradio_delay_min_ms = 1\nradio_delay_ms = 3\n";
const std::string kPerfect = "[faults.phone]\n";

/// The three sensors, bound as a rig that binds none means them.
std::string three_bound() {
  return sensor::write_rig(sensor::with_bindings(test::three_sensors()).value());
}

class WornPhoneTest : public ::testing::Test {
 protected:
  void SetUp() override {
    request_.motion = test::talking(181);  // Three seconds.
    request_.seed = 5;
  }
  const StageRequest& with_rig(const std::string& toml) {
    EXPECT_TRUE(write_file(folder_ / "rig.toml", toml));
    request_.rig = folder_ / "rig.toml";
    return request_;
  }
  Stage staged(const std::string& toml) {
    auto stage = set_stage(with_rig(toml));
    EXPECT_TRUE(stage) << (stage ? "" : stage.error().message());
    return stage ? *std::move(stage) : Stage();
  }
  VirtualSession played(const std::string& toml) { return play(staged(toml)).value(); }
  Error refused(const std::string& toml) {
    const auto stage = set_stage(with_rig(toml));
    EXPECT_FALSE(stage);
    return stage ? Error{} : stage.error();
  }
  mien::test::Folder folder_;
  StageRequest request_;
};

std::vector<take::LogEntry> entries_of(const VirtualSession& session, bool of_phone) {
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : session.entries)
    if (phone::is_live_link(entry.bytes) == of_phone) entries.push_back(entry);
  return entries;
}

/// What a sensor told, by the times of its frames.
std::map<DeviceTime, phone::ToldFace> told_by(std::uint16_t sensor,
                                              const std::vector<take::StoredSample>& samples) {
  std::map<DeviceTime, phone::ToldFace> told;
  for (const take::StoredSample& stored : samples)
    if (stored.sample.sensor == sensor) {
      EXPECT_TRUE(phone::add_sample(stored.sample, told[stored.sample.time]));
    }
  return told;
}

/// That all but the phone is as it is without one.
void expect_same_sensors(const VirtualSession& with, const VirtualSession& without) {
  const std::vector<take::LogEntry> sensors = entries_of(with, false);
  ASSERT_EQ(sensors.size(), without.entries.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    ASSERT_EQ(sensors[i].bytes, without.entries[i].bytes);
    ASSERT_EQ(sensors[i].arrival, without.entries[i].arrival);
  }
  EXPECT_EQ(with.motion_start, without.motion_start);
  ASSERT_EQ(with.ticks.size(), without.ticks.size());
  for (std::size_t i = 0; i < with.ticks.size(); ++i) {
    EXPECT_EQ(with.ticks[i].frame, without.ticks[i].frame);
    EXPECT_EQ(with.truth[i].weights, without.truth[i].weights);
  }
}

TEST_F(WornPhoneTest, APerfectOneTellsTheMotion) {
  const Stage stage = staged(three_bound() + kTruth + kFaults + kPerfect);
  const VirtualSession session = play(stage).value();
  const face::MotionCurve curve(stage.motion.motion);
  const auto told = told_by(3, session.samples);
  EXPECT_NEAR(static_cast<double>(told.size()), 60 * curve.duration_s(), 2);
  for (const auto& [time, face] : told) {
    const face::MotionFrame truth = curve.at(to_seconds(time.time_since_epoch()));
    const phone::InnerFace inner = phone::inner_face(face);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      ASSERT_TRUE(inner.known[k]);
      ASSERT_NEAR(inner.weights[k], std::clamp(truth.weights[k], 0.0F, 1.0F), 1e-6) << k;
    }
    ASSERT_TRUE(face.head);
    const auto& [w, x, y, z] = face.head->rotation;
    ASSERT_LT(angle_between(Quat(double{w}, double{x}, double{y}, double{z}), truth.head), 1e-5);
  }
}

TEST_F(WornPhoneTest, LeavesTheSensorsAsTheyAre) {
  const VirtualSession without = played(three_bound() + kFaults);
  for (const char* role : {"truth", "face"}) {
    const VirtualSession with = played(three_bound() + phone("phone", role) + kFaults);
    EXPECT_GT(entries_of(with, true).size(), 600U);
    expect_same_sensors(with, without);
  }
  // Numbers of the rig are not those of the sensors' part of it.
  std::string first = three_bound();
  first.insert(first.find("[[sensor]]"), kTruth);
  expect_same_sensors(play(staged(first + kFaults)).value(), without);
}

TEST_F(WornPhoneTest, IsAddedToARigThatHasNone) {
  with_rig(test::kRig + kFaults);
  const VirtualSession without = play(set_stage(request_).value()).value();
  request_.phone = true;
  const Stage stage = set_stage(request_).value();
  ASSERT_EQ(sensor::truths_of(stage.rig), std::vector<std::uint16_t>{3});
  EXPECT_EQ(sensor::parse_rig(stage.rig_toml, "stage").value().sensors[3].name, "phone");
  expect_same_sensors(play(stage).value(), without);
  // One of its own stays as it is.
  const std::string own = three_bound() + phone("mine", "face") + kFaults;
  EXPECT_EQ(staged(own).rig_toml, own);
}

TEST_F(WornPhoneTest, IsAUsualOneUnlessTheRigHasItsTable) {
  const auto frame_count = [&](const std::string& faults) {
    return entries_of(played(three_bound() + kTruth + kFaults + faults), true).size();
  };
  const std::size_t perfect = frame_count(kPerfect);
  EXPECT_LT(frame_count(""), perfect) << "some are dropped";
  EXPECT_NEAR(static_cast<double>(frame_count("[faults.phone]\nrate_hz = 30\n")),
              static_cast<double>(perfect) / 2, 2);
  // A file of faults has the table, too.
  ASSERT_TRUE(write_file(folder_ / "faults.toml", "packet_loss = 0.5\n[phone]\nframes_dropped = 1\n"));
  request_.devices = (folder_ / "faults.toml").string();
  EXPECT_EQ(frame_count(kPerfect), 0U);
}

TEST_F(WornPhoneTest, InTheProfileLabItIsPerfect) {
  request_.devices = "lab";
  const VirtualSession without = played(three_bound());
  const Stage stage =
      staged(three_bound() + kTruth + "[faults.phone]\nframes_dropped = 0.5\nlag_ms = [50, 50]\n");
  const VirtualSession session = play(stage).value();
  expect_same_sensors(session, without);
  const face::MotionCurve curve(stage.motion.motion);
  const auto told = told_by(3, session.samples);
  EXPECT_NEAR(static_cast<double>(told.size()), 60 * curve.duration_s(), 2);
  constexpr std::size_t kJawOpen = face::shape("jawOpen");
  for (const auto& [time, face] : told)
    ASSERT_NEAR(phone::inner_face(face).weights[kJawOpen],
                curve.at(to_seconds(time.time_since_epoch())).weights[kJawOpen], 1e-6);
}

/// The hash of a take's frames, as a session gives them again.
std::string hash_of(const std::filesystem::path& path) {
  const take::Take take = take::Take::open(path).value();
  session::Session::Parts parts;
  parts.rig = take.rig();
  parts.trackers.push_back(
      std::make_unique<imu::ImuTracker>(take.rig(), std::make_unique<session::test::TwoShapes>()));
  parts.protocols.push_back(std::make_unique<phone::LiveLinkProtocol>());
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  const auto session = session::Session::create(std::move(parts)).value();
  const session::test::Played played = session::test::run(*session, take.entries().value());
  EXPECT_GT(played.frames.size(), 600U);
  return played.hash;
}

TEST_F(WornPhoneTest, ATakeHoldsItBesideTheTruthAndTheFramesAreTheSame) {
  PerformRequest request;
  static_cast<StageRequest&>(request) = with_rig(test::kRig + kFaults);
  request.take = folder_ / "alone.mien";
  ASSERT_TRUE(perform_take(request, no_progress));
  request.take = folder_ / "both.mien";
  request.phone = true;
  ASSERT_TRUE(perform_take(request, no_progress));
  EXPECT_EQ(hash_of(folder_ / "both.mien"), hash_of(folder_ / "alone.mien"));

  const take::Take take = take::Take::open(request.take).value();
  EXPECT_TRUE(take.check());
  EXPECT_EQ(sensor::truths_of(take.rig()), std::vector<std::uint16_t>{3});
  EXPECT_GT(told_by(3, take.samples().value()).size(), 600U);
  EXPECT_EQ(take.truth().value().size(), take.ticks().value().size());
}

TEST_F(WornPhoneTest, SaysOnTheNetworkWhatATakeOfTheSamePerformanceHolds) {
  const std::string rig = three_bound() + kTruth + kFaults;
  const std::vector<take::LogEntry> packets = entries_of(played(rig), true);
  for (const NodeLanguage language : {NodeLanguage::mien, NodeLanguage::slimevr}) {
    const auto group = NodeGroup::create(staged(rig), language, false).value();
    NodeGroup& nodes = *group;
    ASSERT_EQ(nodes.size(), 4U);
    EXPECT_FALSE(nodes[3].listens());
    EXPECT_EQ(nodes[3].device(), phone::kLiveLinkDevice);
    std::map<std::vector<std::byte>, HostTime> said;
    nodes.begin(HostTime());
    for (double t = -0.3; t < 30 && !nodes.finished(); t += 0.001) {
      while (nodes.simulated_s() < t) ASSERT_TRUE(nodes.simulate());
      for (std::size_t n = 0; n < nodes.size(); ++n)
        while (auto datagram = nodes[n].next_datagram(HostTime(from_seconds(t))))
          if (n == 3) said.emplace(*std::move(datagram), HostTime(from_seconds(t)));
    }
    EXPECT_TRUE(nodes.finished());
    for (const take::LogEntry& entry : packets) {
      const auto found = said.find(entry.bytes);
      ASSERT_NE(found, said.end());
      EXPECT_GE(found->second, entry.arrival);
      EXPECT_LE(found->second, entry.arrival + std::chrono::microseconds(1'001));
    }
    EXPECT_NEAR(static_cast<double>(said.size()), static_cast<double>(packets.size()), 2);
  }
}

TEST_F(WornPhoneTest, GoesOnWhereThePerformanceIsToldTo) {
  const auto group =
      NodeGroup::create(staged(three_bound() + kTruth + kPerfect), NodeLanguage::mien, true).value();
  NodeGroup& nodes = *group;
  nodes.begin(HostTime());
  std::map<std::size_t, std::size_t> open;  // Frames of an open jaw by round.
  for (double t = -0.3; t < 40; t += 0.005) {
    while (nodes.simulated_s() < t) ASSERT_TRUE(nodes.simulate());
    while (auto datagram = nodes[3].next_datagram(HostTime(from_seconds(t))))
      if (phone::parse_live_link(*datagram)->values.value()[17] > 0.5F) ++open[nodes.round_at(t).number];
  }
  EXPECT_FALSE(nodes.finished());
  ASSERT_GT(open.size(), 4U);
  for (const auto& [round, frames] : open)
    if (round < open.rbegin()->first) {
      // A second and a half of the motion, and as it returns from an open jaw.
      EXPECT_NEAR(static_cast<double>(frames), 115, 4) << round;
    }
}

TEST_F(WornPhoneTest, LooksOnWhateverIsWorn) {
  request_.phone = true;
  request_.motion = test::talking(61);
  request_.rig = project_path("rigs/eyewear.toml");
  const VirtualSession glasses = play(set_stage(request_).value()).value();
  EXPECT_GT(entries_of(glasses, true).size(), 300U);
  for (const char* rig : {"rigs/headset.toml", "rigs/imu_headset.toml", "rigs/imu_microphone.toml"}) {
    request_.rig = project_path(rig);
    const auto stage = set_stage(request_);
    ASSERT_TRUE(stage) << stage.error().message();
    EXPECT_EQ(sensor::truths_of(stage->rig).size(), 1U);
  }
  const VirtualSession heard = played(
      "name = \"ear\"\nreference = \"ear\"\n[[sensor]]\nname = \"ear\"\nkind = \"speech\"\nrole = \"face\"\n"
      "device = \"02:4D:49:53:4E:01\"\n");
  EXPECT_GT(entries_of(heard, true).size(), 60U);
  EXPECT_EQ(heard.truth.size(), heard.ticks.size());
}

TEST_F(WornPhoneTest, RefusesWhatCannotBe) {
  Error error = refused(three_bound() + kTruth + phone("other", "face", "02:4D:49:50:48:01"));
  EXPECT_EQ(error.code, ErrorCode::unsupported);
  EXPECT_THAT(error.message(), HasSubstr("one phone"));
  error = refused(three_bound() + phone("phone", "truth", "02:4D:49:46:4D:00"));
  EXPECT_EQ(error.code, ErrorCode::bad_usage);
  EXPECT_THAT(error.message(), HasSubstr("02:4D:49:50:48:00")) << "what to do";
  error = refused("name = \"phone\"\nreference = \"phone\"\n" + phone("phone", "face"));
  EXPECT_EQ(error.code, ErrorCode::bad_usage);
  EXPECT_THAT(error.message(), HasSubstr("reference"));
  std::string rig = three_bound();
  rig.replace(rig.find("mastoid_L"), 9, "phone");
  EXPECT_THAT(refused(rig + phone("phone", "face")).message(), HasSubstr("reference"));
  EXPECT_THAT(refused(three_bound() + kTruth + "[faults.phone]\ngyro_scale = 1\n").message(),
              HasSubstr("gyro_scale"));
  EXPECT_EQ(refused(three_bound() + kTruth + "[faults]\nphone = 3\n").code, ErrorCode::malformed);
}

}  // namespace
}  // namespace mien::virt::worn_phone_test
