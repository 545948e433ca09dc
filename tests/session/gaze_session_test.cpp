#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "mien/gaze/gaze_protocol.h"
#include "mien/gaze/gaze_tracker.h"
#include "mien/gaze/packet.h"
#include "mien/sensor/rig_part.h"
#include "tests/gaze/osc_bytes.h"
#include "tests/session/session_run.h"

// A tracker of gaze beside IMUs in one session.
namespace mien::session::gaze_session_test {
namespace {

using face::Provenance;
using face::shape;
using test::kPrologue_s;
using test::Played;

const std::size_t kJaw = shape("jawOpen");
const std::size_t kOut = shape("eyeLookOut_L");
const std::size_t kIn = shape("eyeLookIn_L");
const std::size_t kBlink = shape("eyeBlink_L");
constexpr std::uint64_t kHeadset = 0x024D'4945'4E60ULL;

/// Where the eyes look, rad to the performer's left, by the session's time: a slow sweep.
double yaw_at(double t_s) {
  return 0.4 * std::sin(t_s);
}

/// TwoShapes, of whose lids nothing is known, as of any sensor on the skin.
class SkinModel final : public tracker::FrameModel {
 public:
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    shapes_.step(features, out);
    for (std::size_t i = 0; i < face::kShapeCount; ++i) {
      if (!face::kShapeNames[i].starts_with("eye")) continue;
      out.weights[i] = 0.3F;
      out.confidence[i] = 0.1F;
      out.provenance[i] = Provenance::predicted;
    }
  }
  void reset() override { shapes_.reset(); }

 private:
  test::TwoShapes shapes_;
};

sensor::Rig gaze_rig(std::uint64_t device) {
  sensor::Rig rig = virt::test::three_sensors();
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    rig.sensors[i].device = sensor::format_device({0x024D'4945'4E00ULL + i, 0});
  rig.sensors.push_back(
      {.name = "eyes", .kind = "gaze", .role = "face", .device = sensor::format_device({device, 0})});
  return rig;
}

std::unique_ptr<Session> session(const sensor::Rig& rig) {
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(
      std::make_unique<imu::ImuTracker>(sensor::part_of(rig, "imu"), std::make_unique<SkinModel>()));
  parts.trackers.push_back(gaze::GazeTracker::create(sensor::part_of(rig, "gaze")).value());
  parts.protocols.push_back(std::make_unique<gaze::GazeProtocol>());
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

using Send = std::vector<std::vector<std::byte>> (*)(std::uint32_t number, double t_s);

/// What EyeTrackVR sends: a coordinate a datagram.
std::vector<std::vector<std::byte>> by_osc(std::uint32_t, double t_s) {
  const auto x = static_cast<float>(-std::tan(yaw_at(t_s)));
  std::vector<std::vector<std::byte>> sent;
  for (const char* name : {"EyeLeftX", "EyeRightX", "EyeLeftY", "EyeRightY", "EyeLidLeft", "EyeLidRight"}) {
    const std::string_view text(name);
    const float value = text.ends_with('X') ? x : text.ends_with('Y') ? 0 : 0.6F;
    sent.push_back(gaze::test::message(std::string("/avatar/parameters/v2/") + name, {value}));
  }
  return sent;
}

/// The same in our packets; the headset began 50 s before the session.
std::vector<std::vector<std::byte>> by_packet(std::uint32_t number, double t_s) {
  gaze::Packet packet{.device = kHeadset, .sequence = number};
  packet.time = DeviceTime(std::chrono::microseconds(std::llround(1e6 * (50 + t_s))));
  packet.eyes.fill({.yaw_rad = static_cast<float>(yaw_at(t_s)), .confidence = 1, .openness = 0.8F});
  return {gaze::encode_packet(packet).value()};
}

/// The IMUs' packets, and 60 times a second the eyes' until `end_s`, by arrival.
std::vector<take::LogEntry> with_eyes(const virt::VirtualSession& imus, Send send, double end_s = 1e9) {
  std::vector<take::LogEntry> entries = imus.entries;
  end_s = std::min(end_s, to_seconds(entries.back().arrival.time_since_epoch()));
  Random random(8);
  std::int64_t id = entries.back().id;
  for (std::uint32_t n = 0; n / 60.0 < end_s; ++n) {
    const HostTime arrival(from_seconds(n / 60.0 + 0.001 + random.uniform(0, 0.002)));
    for (auto& datagram : send(n, n / 60.0))
      entries.push_back({++id, arrival, "udp://10.0.0.7:1", std::move(datagram)});
  }
  std::ranges::sort(entries, {},
                    [](const take::LogEntry& e) { return std::tuple(e.arrival, e.source, e.id); });
  return entries;
}

double fired_s(const Played::Frame& frame) {
  return to_seconds(frame.tick.fired.time_since_epoch());
}

void expect_eyes_beside_imus(std::uint64_t device, Send send) {
  const virt::VirtualSession performed = test::performance(6);
  const auto entries = with_eyes(performed, send);
  const sensor::Rig rig = gaze_rig(device);
  const auto both = session(rig);
  const Played run = test::run(*both, entries);
  test::expect_sound(run);
  std::size_t compared = 0;
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    if (t < kPrologue_s + 1) continue;
    const face::OutputFrame& frame = f.frame;
    ASSERT_EQ(frame.provenance[kJaw], Provenance::measured) << "the IMUs'";
    ASSERT_EQ(frame.eyes_provenance, Provenance::measured);
    ASSERT_EQ(frame.eyes_confidence, 1);
    // A frame stands some tens of milliseconds before it fires; the eyes move by at most 0.4 rad/s.
    ASSERT_NEAR(frame.eyes_rad[0].x(), yaw_at(t), 0.04) << t;
    ASSERT_NEAR(frame.eyes_rad[1].x(), yaw_at(t), 0.04) << t;
    ASSERT_NEAR(frame.weights[kOut] - frame.weights[kIn], frame.eyes_rad[0].x() / 0.611, 1e-5);
    ASSERT_EQ(std::min(frame.weights[kOut], frame.weights[kIn]), 0);
    ASSERT_EQ(frame.provenance[kOut], Provenance::measured);
    ASSERT_EQ(frame.confidence[kOut], 1);
    ASSERT_NEAR(frame.weights[kBlink], 0.2, 0.002);
    ASSERT_EQ(frame.provenance[kBlink], Provenance::measured);
    ++compared;
  }
  EXPECT_GT(compared, 250U);
  // The log replays to the same bits.
  EXPECT_EQ(test::run(*session(rig), run.log).hash, run.hash);
}

TEST(GazeSession, EyesByOscAnswerBesideImus) {
  expect_eyes_beside_imus(gaze::kOscDevice, by_osc);
}

TEST(GazeSession, EyesByOurPacketsAnswerBesideImus) {
  expect_eyes_beside_imus(kHeadset, by_packet);
}

TEST(GazeSession, WhenTheEyesAreLostTheImusLidsComeBackSoftly) {
  const virt::VirtualSession performed = test::performance(6);
  const double lost_s = kPrologue_s + 2;
  const Played run = test::run(*session(gaze_rig(kHeadset)), with_eyes(performed, by_packet, lost_s));
  EXPECT_EQ(run.count("sensor_lost"), 1U);
  const Played::Frame* before = nullptr;
  double most = 0;
  for (const Played::Frame& f : run.frames) {
    if (before != nullptr && fired_s(f) > kPrologue_s + 1)
      for (const std::size_t i : {kOut, kIn, kBlink})
        most = std::max<double>(most, std::abs(f.frame.weights[i] - before->frame.weights[i]));
    before = &f;
  }
  EXPECT_LT(most, 0.1);
  ASSERT_NE(before, nullptr);
  EXPECT_NEAR(before->frame.weights[kOut], 0.3, 1e-3);
  EXPECT_NEAR(before->frame.weights[kBlink], 0.3, 1e-3);
  EXPECT_EQ(before->frame.provenance[kOut], Provenance::predicted);
  EXPECT_EQ(before->frame.eyes_provenance, Provenance::predicted);
}

}  // namespace
}  // namespace mien::session::gaze_session_test
