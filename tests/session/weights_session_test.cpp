#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "mien/core/bytes.h"
#include "mien/gaze/gaze_protocol.h"
#include "mien/gaze/gaze_tracker.h"
#include "mien/gaze/packet.h"
#include "mien/phone/packet.h"
#include "mien/phone/weights_protocol.h"
#include "mien/phone/weights_tracker.h"
#include "mien/sensor/rig_part.h"
#include "tests/session/session_run.h"

// Another program's weights and head beside IMUs and a tracker of gaze in one session.
namespace mien::session::weights_session_test {
namespace {

using face::Provenance;
using face::shape;
using test::kPrologue_s;
using test::Played;

const std::size_t kJaw = shape("jawOpen");
const std::size_t kNose = shape("noseSneer_L");
const std::size_t kBrow = shape("browOuterUp_L");
constexpr std::uint64_t kHeadset = 0x024D'4945'4E60ULL;
constexpr std::uint64_t kPhone = 0x024D'4945'4E70ULL;

// By the session's time, slowly enough for frames that stand some tens of milliseconds before they fire.
double jaw_at(double t_s) {
  return 0.5 + 0.3 * std::sin(t_s);
}
double yaw_at(double t_s) {
  return 0.2 * std::sin(t_s);
}
double left_at(double t_s) {
  return 0.1 * std::sin(t_s);  // Of the head, m.
}

/// TwoShapes, whose noses sneer.
class SneeringModel final : public tracker::FrameModel {
 public:
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    shapes_.step(features, out);
    out.weights[kNose] = 0.25F;
  }
  void reset() override { shapes_.reset(); }

 private:
  test::TwoShapes shapes_;
};

sensor::Rig rig_of_three() {
  sensor::Rig rig = virt::test::three_sensors();
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    rig.sensors[i].device = sensor::format_device({0x024D'4945'4E00ULL + i, 0});
  rig.sensors.push_back(
      {.name = "eyes", .kind = "gaze", .role = "face", .device = sensor::format_device({kHeadset, 0})});
  rig.sensors.push_back(
      {.name = "phone", .kind = "weights", .role = "face", .device = sensor::format_device({kPhone, 0})});
  return rig;
}

std::unique_ptr<Session> session() {
  const sensor::Rig rig = rig_of_three();
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(
      std::make_unique<imu::ImuTracker>(sensor::part_of(rig, "imu"), std::make_unique<SneeringModel>()));
  parts.trackers.push_back(gaze::GazeTracker::create(sensor::part_of(rig, "gaze")).value());
  parts.trackers.push_back(phone::WeightsTracker::create(sensor::part_of(rig, "weights")).value());
  parts.protocols.push_back(std::make_unique<gaze::GazeProtocol>());
  parts.protocols.push_back(std::make_unique<phone::WeightsProtocol>());
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// The headset began 50 s before the session, the phone 80 s.
std::vector<std::byte> gaze_packet(std::uint32_t number, double t_s) {
  gaze::Packet packet{.device = kHeadset, .sequence = number};
  packet.time = DeviceTime(std::chrono::microseconds(std::llround(1e6 * (50 + t_s))));
  packet.eyes.fill({.yaw_rad = static_cast<float>(yaw_at(t_s)), .confidence = 1});
  return gaze::encode_packet(packet).value();
}

std::vector<std::byte> phone_packet(std::uint32_t number, double t_s) {
  phone::Packet packet{.device = kPhone, .sequence = number};
  packet.time = DeviceTime(std::chrono::microseconds(std::llround(1e6 * (80 + t_s))));
  packet.face.set = phone::ShapeSet::arkit52;
  packet.face.origin = phone::Origin::measured;
  // All that ARKit tells, at rest but for the jaw and a brow.
  for (std::size_t i = 0; i < face::kArkitCount; ++i) packet.face.weights[i] = 0;
  packet.face.weights[face::arkit_index("jawOpen")] = static_cast<float>(jaw_at(t_s));
  packet.face.weights[face::arkit_index("browOuterUpLeft")] = 0.4F;
  const double half = yaw_at(t_s) / 2;
  packet.face.head = phone::ToldHead{
      .position_m = {static_cast<float>(1 + left_at(t_s)), 1.5F, -0.25F},
      .position_known = true,
      .rotation = {static_cast<float>(std::cos(half)), 0, static_cast<float>(std::sin(half)), 0}};
  return phone::encode_packet(packet).value();
}

/// Until when each sends, s; the phone sends 30 packets a second, the headset 60.
struct Senders {
  double imus_s = 1e9;
  double gaze_s = 1e9;
  double phone_s = 1e9;
};

std::vector<take::LogEntry> entries_of(const virt::VirtualSession& imus, const Senders& senders) {
  const double end_s = to_seconds(imus.entries.back().arrival.time_since_epoch());
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : imus.entries)
    if (to_seconds(entry.arrival.time_since_epoch()) < senders.imus_s) entries.push_back(entry);
  Random random(8);
  std::int64_t id = imus.entries.back().id;
  const auto add = [&](const char* from, double t_s, std::vector<std::byte> datagram) {
    const HostTime arrival(from_seconds(t_s + 0.001 + random.uniform(0, 0.002)));
    entries.push_back({++id, arrival, from, std::move(datagram)});
  };
  for (std::uint32_t n = 0; n / 60.0 < std::min(end_s, senders.gaze_s); ++n)
    add("udp://10.0.0.7:1", n / 60.0, gaze_packet(n, n / 60.0));
  for (std::uint32_t n = 0; n / 30.0 < std::min(end_s, senders.phone_s); ++n)
    add("udp://10.0.0.8:1", n / 30.0, phone_packet(n, n / 30.0));
  std::ranges::sort(entries, {},
                    [](const take::LogEntry& e) { return std::tuple(e.arrival, e.source, e.id); });
  return entries;
}

/// The hash of a replay: the log's entries, the page's commands among them, and its ticks.
std::string replayed(const Played& live) {
  const auto again = session();
  Peers peers;
  std::size_t entry = 0;
  for (const Played::Frame& f : live.frames) {
    for (; entry < static_cast<std::size_t>(f.tick.after_entry); ++entry) {
      const take::LogEntry& e = live.log[entry];
      if (e.source == kPageSource) {
        EXPECT_TRUE(again->command(e.arrival, as_text(e.bytes)));
      } else {
        again->receive(e.arrival, peers.of(e.source), e.bytes);
      }
    }
    again->tick(f.tick.frame, f.tick.fired);
  }
  return again->hash();
}

double fired_s(const Played::Frame& frame) {
  return to_seconds(frame.tick.fired.time_since_epoch());
}

TEST(WeightsSession, EachAnswersWhatIsItsOwn) {
  const virt::VirtualSession performed = test::performance(6);
  const Played run = test::run(*session(), entries_of(performed, {}));
  test::expect_sound(run);
  std::size_t compared = 0;
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    if (t < kPrologue_s + 1) continue;
    const face::OutputFrame& frame = f.frame;
    ASSERT_NEAR(frame.weights[kJaw], jaw_at(t), 0.03) << t;
    ASSERT_EQ(frame.provenance[kJaw], Provenance::measured);
    ASSERT_EQ(frame.confidence[kJaw], phone::kDefaultConfidence) << "the phone's";
    ASSERT_NEAR(frame.weights[kBrow], 0.4, 1e-6);
    ASSERT_NEAR(frame.weights[kNose], 0.25, 1e-6) << "the IMUs'";
    ASSERT_EQ(frame.confidence[kNose], 1);
    ASSERT_NEAR(frame.eyes_rad[0].x(), yaw_at(t), 0.02) << "the headset's";
    ASSERT_EQ(frame.eyes_confidence, 1);
    ASSERT_LT(angle_between(frame.head, exp_rotation({0, yaw_at(t), 0})), 0.02) << t;
    ASSERT_TRUE(frame.head_position_known);
    ASSERT_NEAR(frame.head_position_m.x(), left_at(t), 0.01) << t;
    ASSERT_NEAR(frame.head_position_m.y(), 0, 1e-6);
    ASSERT_EQ(frame.head_confidence, phone::kDefaultConfidence);
    ++compared;
  }
  EXPECT_GT(compared, 250U);
  const Report::Link& link = run.report.links.back();
  EXPECT_EQ(link.health.state, sensor::LinkState::good) << sensor::link_state_name(link.health.state);
  EXPECT_NEAR(link.health.rate_hz, 30, 1.5);
  ASSERT_TRUE(link.health.clock);
  EXPECT_NEAR(to_seconds(link.health.clock->offset), -80, 0.01);
  EXPECT_EQ(link.health.doubled + link.health.lost + link.health.restarts, 0U);
  // The log replays to the same bits, ten times.
  for (int i = 0; i < 10; ++i) ASSERT_EQ(replayed(run), run.hash);
}

TEST(WeightsSession, RecentringTurnsAndMovesTheHead) {
  const virt::VirtualSession performed = test::performance(6);
  const Played run = test::run(*session(), entries_of(performed, {}),
                               {{.at_s = kPrologue_s + 1, .json = R"({"command": "recentre"})"}});
  const face::OutputFrame& last = run.frames.back().frame;
  const double t = fired_s(run.frames.back());
  // Measured over a second, after the two of rest that the IMUs want, in which the heading and the place were
  // about those of its middle.
  const double middle_s = kPrologue_s + 1 + 2 + 0.5, yaw = yaw_at(middle_s);
  const Vec3 moved = exp_rotation({0, -yaw, 0}) * Vec3(left_at(t) - left_at(middle_s), 0, 0);
  EXPECT_LT(angle_between(last.head, exp_rotation({0, yaw_at(t) - yaw, 0})), 0.03);
  EXPECT_LT((last.head_position_m.cast<double>() - moved).norm(), 0.015);
  EXPECT_EQ(replayed(run), run.hash);
}

TEST(WeightsSession, WhenThePhoneIsLostTheImusAnswer) {
  const virt::VirtualSession performed = test::performance(6);
  const double lost_s = kPrologue_s + 2;
  const Played run = test::run(*session(), entries_of(performed, {.phone_s = lost_s}));
  EXPECT_EQ(run.count("sensor_lost"), 1U);
  const face::OutputFrame* before = nullptr;
  double most_m = 0, most_rad = 0;
  for (const Played::Frame& f : run.frames) {
    if (before != nullptr && fired_s(f) > kPrologue_s + 1) {
      most_m = std::max<double>(most_m, (f.frame.head_position_m - before->head_position_m).norm());
      most_rad = std::max(most_rad, angle_between(f.frame.head, before->head));
    }
    before = &f.frame;
  }
  EXPECT_LT(most_m, 0.0125) << "0.0975 of at most 0.1 m, and the head's own";
  EXPECT_LT(most_rad, 0.1);
  ASSERT_NE(before, nullptr);
  EXPECT_FALSE(before->head_position_known);
  EXPECT_EQ(before->head_position_m, Vec3f(0, 0, 0));
  EXPECT_EQ(before->head_confidence, 1) << "the IMUs'";
  EXPECT_EQ(before->confidence[kJaw], 1);
  EXPECT_EQ(before->provenance[kJaw], Provenance::measured);
  EXPECT_EQ(before->eyes_confidence, 1) << "the headset's still";
  EXPECT_EQ(replayed(run), run.hash);
}

TEST(WeightsSession, WhenTheImusAreLostThePhoneAnswersForThem) {
  const virt::VirtualSession performed = test::performance(6);
  const double lost_s = kPrologue_s + 2;
  const Played run = test::run(*session(), entries_of(performed, {.imus_s = lost_s}));
  EXPECT_EQ(run.count("sensor_lost"), 3U);
  EXPECT_LT(test::largest_step(run, kPrologue_s + 1), 0.1);
  const face::OutputFrame& last = run.frames.back().frame;
  EXPECT_EQ(last.weights[kNose], 0) << "the phone's, at rest";
  EXPECT_EQ(last.confidence[kNose], phone::kDefaultConfidence);
  EXPECT_NEAR(last.weights[kJaw], jaw_at(fired_s(run.frames.back())), 0.03);
  EXPECT_TRUE(last.head_position_known);
}

}  // namespace
}  // namespace mien::session::weights_session_test
