#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/units.h"
#include "mien/imu/packets/packet.h"
#include "mien/modalities/osc_commands.h"
#include "tests/gaze/osc_bytes.h"
#include "tests/session/session_run.h"

// Re-centring of sensors on the skin: drift first, then the centre.
namespace mien::session::recentre_session_test {
namespace {

using Json = nlohmann::json;
using test::kPrologue_s;
using test::Played;

constexpr const char* kRecentre = R"({"command": "recentre"})";
/// Of three_sensors().
constexpr std::size_t kCheek = 1;

/// Keeps what the pipeline gave.
class Watching final : public tracker::FrameModel {
 public:
  struct Seen {
    DeviceTime time;
    std::vector<std::optional<Vec3>> turn_rad;
  };
  explicit Watching(std::vector<Seen>& seen) : seen_(&seen) {}
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    Seen& one = seen_->emplace_back(Seen{.time = features.time, .turn_rad = {}});
    for (const model::SensorFeature& f : features.sensors)
      one.turn_rad.push_back(f.has_rotation ? std::optional(log_rotation(Quat(f.rotation[0], f.rotation[1],
                                                                              f.rotation[2], f.rotation[3])))
                                            : std::nullopt);
    two_.step(features, out);
  }
  void reset() override {}

 private:
  test::TwoShapes two_;
  std::vector<Seen>* seen_;
};

std::unique_ptr<Session> watched_session(std::vector<Watching::Seen>& seen) {
  Session::Parts parts;
  parts.rig = virt::test::three_sensors();
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(parts.rig, std::make_unique<Watching>(seen)));
  parts.protocols.push_back(std::make_unique<modalities::OscCommands>());
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// A performer who talks for a second after the prologue and then rests, without gyroscopes' bias.
virt::VirtualSession resting_performance(double seconds) {
  face::Motion motion = virt::test::talking(static_cast<int>(60 * seconds));
  for (std::size_t f = 60; f < motion.frames.size(); ++f) {
    motion.frames[f].weights = {};
    motion.frames[f].head = Quat::Identity();
  }
  const performer::PrologueMotion whole =
      performer::with_prologue(motion, performer::PrologueKind::brief, Random(3));
  virt::DeviceFaults faults = virt::test::mild_faults();
  faults.packet_loss = 0;
  faults.gyro_bias_dps = 0;
  return virt::play_devices(whole, virt::test::three_sites(), virt::test::three_sensors(), faults, Random(11))
      .value();
}

/// The same where the sensor is turned on its skin by this within half a second.
std::vector<take::LogEntry> pushed(const virt::VirtualSession& performed, std::uint16_t sensor, double at_s,
                                   const Vec3& turn_rad) {
  std::map<std::int64_t, std::uint16_t> of;
  for (const take::StoredSample& s : performed.samples) of[s.entry] = s.sample.sensor;
  std::vector<take::LogEntry> entries = performed.entries;
  for (take::LogEntry& entry : entries) {
    const auto found = of.find(entry.id);
    if (found == of.end() || found->second != sensor) continue;
    imu::Packet packet = imu::parse_packet(entry.bytes).value();
    for (std::size_t i = 0; i < packet.count; ++i) {
      const double t = to_seconds(entry.arrival.time_since_epoch()) +
                       to_seconds(packet.interval) * (static_cast<double>(i) - packet.count);
      const double u = std::clamp((t - at_s) / 0.5, 0.0, 1.0);
      const Quat back = exp_rotation(-u * turn_rad);
      const auto turn = [&](std::size_t from, const Vec3& added) {
        auto& values = packet.values[i];
        const Vec3 turned = back * Vec3(values[from], values[from + 1], values[from + 2]) + added;
        for (std::size_t axis = 0; axis < 3; ++axis)
          values[from + axis] = static_cast<float>(turned[static_cast<Eigen::Index>(axis)]);
      };
      turn(0, u > 0 && u < 1 ? Vec3(turn_rad / 0.5) : Vec3(Vec3::Zero()));
      turn(3, Vec3::Zero());
    }
    entry.bytes = imu::encode_packet(packet).value();
  }
  return entries;
}

/// The largest angle of a sensor's rotation on a stretch, deg.
double largest_deg(const std::vector<Watching::Seen>& seen, std::size_t sensor, double from_s, double to_s) {
  double largest = 0;
  std::size_t frames = 0;
  for (const Watching::Seen& one : seen) {
    const double t = to_seconds(one.time.time_since_epoch());
    if (t < from_s || t >= to_s || !one.turn_rad[sensor]) continue;
    largest = std::max(largest, kDegPerRad * one.turn_rad[sensor]->norm());
    ++frames;
  }
  EXPECT_GT(frames, 0u);
  return largest;
}

const take::Event* find(const Played& run, const std::string& kind) {
  const auto found = std::ranges::find(run.events, kind, &take::Event::kind);
  return found == run.events.end() ? nullptr : &*found;
}

double at_s(const take::Event& event) {
  return to_seconds(event.end.time_since_epoch());
}

TEST(RecentreSession, CorrectsASensorThatWasPutOnAgain) {
  const virt::VirtualSession performed = resting_performance(14);
  const std::vector<take::LogEntry> entries = pushed(performed, kCheek, 15, Vec3(18, -12, 14) * kRadPerDeg);
  std::vector<Watching::Seen> seen, frozen;
  const auto session = watched_session(seen);
  const Played run = test::run(*session, entries, {{18, kRecentre}});
  const auto without = watched_session(frozen);
  test::run(*without, entries);
  const double begun_s = at_s(*find(run, "recentre"));
  const double end_s = begun_s + 8;
  EXPECT_GT(largest_deg(frozen, kCheek, begun_s, end_s), 15) << "nothing else finds it";
  EXPECT_LT(largest_deg(seen, kCheek, begun_s + 2.1, end_s), 2);
  EXPECT_LT(largest_deg(seen, 0, begun_s + 2.1, end_s), 2);

  ASSERT_EQ(run.count("rested"), 1u);
  const Json rested = Json::parse(find(run, "rested")->json);
  EXPECT_EQ(rested["corrected"], Json({"mentalis", "buccinator_L"}));
  EXPECT_TRUE(rested["moved"].empty());
  EXPECT_NEAR(at_s(*find(run, "rested")) - begun_s, 2, 0.05);
  // The centre is measured on the corrected weights.
  ASSERT_EQ(session->versions().size(), 2u);
  EXPECT_EQ(session->versions()[1].origin, "recentre");
  EXPECT_NEAR(to_seconds(session->versions()[1].made.time_since_epoch()) - begun_s, 3.5, 0.1);
  const shaping::Centre centre = shaping::parse_centre(session->versions()[1].centre, "test").value();
  EXPECT_LT(centre.rest[face::shape("mouthSmile_L")], 0.1F);
  // For people.
  ASSERT_TRUE(run.report.calibration.sigma_rad);
  EXPECT_LT(*run.report.calibration.sigma_rad, 3 * kRadPerDeg);
  ASSERT_TRUE(run.report.calibration.age_s && run.report.calibration.recentred_s);
  EXPECT_NEAR(*run.report.calibration.age_s - *run.report.calibration.recentred_s,
              to_seconds(session->versions()[1].made - session->versions()[0].made), 1e-6);
  ASSERT_TRUE(run.report.links[kCheek].certainty);
  EXPECT_FALSE(run.report.links[kCheek].certainty->left_out);
  EXPECT_FALSE(run.report.links[2].certainty) << "the ear sensor is no face sensor";

  // The version brings it back.
  EXPECT_TRUE(
      session->command(HostTime(from_seconds(100)), R"({"command": "use_calibration", "version": 2})"));
}

TEST(RecentreSession, TheSameLogGivesTheSameBits) {
  const std::vector<take::LogEntry> entries =
      pushed(resting_performance(10), kCheek, 15, Vec3(0, 20, 0) * kRadPerDeg);
  std::vector<Watching::Seen> seen;
  const Played live = test::run(*watched_session(seen), entries, {{16, kRecentre}, {17, kRecentre}});
  EXPECT_EQ(live.count("rested"), 1u) << "the second begins anew";
  const auto session = watched_session(seen);
  Peers peers;
  std::size_t entry = 0;
  for (const Played::Frame& f : live.frames) {
    for (; entry < static_cast<std::size_t>(f.tick.after_entry); ++entry) {
      const take::LogEntry& e = live.log[entry];
      if (e.source == kPageSource)
        EXPECT_TRUE(
            session->command(e.arrival, {reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size()}));
      else
        session->receive(e.arrival, peers.of(e.source), e.bytes);
    }
    session->tick(f.tick.frame, f.tick.fired);
  }
  EXPECT_EQ(session->hash(), live.hash);
}

TEST(RecentreSession, AnEarlierVersionEndsARestThatWasAskedFor) {
  std::vector<Watching::Seen> seen;
  const auto session = watched_session(seen);
  const Played run = test::run(*session, resting_performance(8).entries,
                               {{15, kRecentre}, {16, R"({"command": "use_calibration", "version": 1})"}});
  EXPECT_EQ(run.count("rested"), 0u);
  EXPECT_EQ(session->versions().size(), 1u);
  EXPECT_EQ(run.report.calibration.in_force, 1);
}

TEST(RecentreSession, AGuidedCalibrationEndsARecentring) {
  std::vector<Watching::Seen> seen;
  const auto session = watched_session(seen);
  const Played run = test::run(*session, resting_performance(8).entries,
                               {{15, kRecentre}, {15.2, R"({"command": "calibrate", "kind": "short"})"}});
  EXPECT_EQ(run.count("recentre"), 1u) << "asked for";
  EXPECT_EQ(run.count("rested"), 0u);
  for (const CalibrationVersion& version : session->versions()) EXPECT_NE(version.origin, "recentre");
}

TEST(RecentreSession, AFaceThatSpeaksIsCentredAndItsDriftIsNotCorrected) {
  const virt::VirtualSession performed = test::performance(8);
  std::vector<Watching::Seen> seen;
  const Played run = test::run(*watched_session(seen), performed.entries, {{14, kRecentre}});
  ASSERT_EQ(run.count("rested"), 1u);
  EXPECT_EQ(Json::parse(find(run, "rested")->json)["moved"], Json({"mentalis", "buccinator_L"}));
  EXPECT_EQ(run.report.calibration.versions.size(), 2u);
}

/// A tracker whose sensors are as uncertain as it is told, and whose filter begins anew.
class Uncertain final : public tracker::Tracker {
 public:
  explicit Uncertain(const double& sigma_deg, const std::uint64_t& faults)
      : sigma_deg_(&sigma_deg), faults_(&faults) {}
  [[nodiscard]] std::string_view modality() const override { return "imu"; }
  void add(HostTime, const sensor::Sample&) override {}
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines&, face::OutputFrame& out) override {
    out = {};
    out.time = frame;
    return {};
  }
  [[nodiscard]] tracker::CalibrationState calibration_state() const override { return {}; }
  [[nodiscard]] std::string calibration() const override { return "{}"; }
  [[nodiscard]] Result<void> restore(std::string_view) override { return {}; }
  [[nodiscard]] std::optional<tracker::SensorCertainty> certainty(std::uint16_t sensor) const override {
    if (sensor == 2) return std::nullopt;
    return tracker::SensorCertainty{.sigma_rad = kRadPerDeg * *sigma_deg_, .left_out = sensor == kCheek};
  }
  [[nodiscard]] std::uint64_t faults() const override { return *faults_; }

 private:
  const double* sigma_deg_;
  const std::uint64_t* faults_;
};

TEST(RecentreSession, IsAdvisedOnceWhereRotationsAreUncertainAndAFaultIsNamed) {
  double sigma_deg = 6;
  std::uint64_t faults = 0;
  Session::Parts parts;
  parts.rig = virt::test::three_sensors();
  parts.trackers.push_back(std::make_unique<Uncertain>(sigma_deg, faults));
  const auto session = Session::create(std::move(parts)).value();
  std::vector<take::Event> events;
  for (int frame = 0; frame < 60 * 30; ++frame) {
    if (frame == 600) faults = 2;
    session->tick(DeviceTime(frame_offset(frame)), HostTime(frame_offset(frame)));
    for (take::Event& event : session->take_events()) events.push_back(std::move(event));
  }
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, "recentre_advised");
  EXPECT_NEAR(at_s(events[0]), 10, 1e-6);
  const Json advised = Json::parse(events[0].json);
  EXPECT_NEAR(advised["sigma_deg"].get<double>(), 6, 1e-9);
  EXPECT_EQ(advised["left_out"], Json({"buccinator_L"}));
  EXPECT_EQ(events[1].kind, "drift_fault");
  EXPECT_EQ(Json::parse(events[1].json)["count"], 2);
  Report report;
  session->report(HostTime(from_seconds(30)), report);
  EXPECT_TRUE(report.calibration.advises_recentring);
  EXPECT_EQ(report.calibration.faults, 2U);
  EXPECT_FALSE(report.calibration.age_s) << "nothing was ever calibrated";
  EXPECT_FALSE(report.links[2].certainty);
}

/// A command by OSC at a time, among a log's entries.
take::LogEntry asked_by_osc(double at_s, const std::string& source, float value = 1) {
  return {0, HostTime(from_seconds(at_s)), source, gaze::test::message("/mien/recentre", {value})};
}

std::vector<take::LogEntry> with(std::vector<take::LogEntry> entries,
                                 const std::vector<take::LogEntry>& added) {
  for (const take::LogEntry& entry : added)
    entries.insert(std::ranges::upper_bound(entries, entry.arrival, {}, &take::LogEntry::arrival), entry);
  return entries;
}

TEST(RecentreSession, ADatagramAsksForItOnceInFiveSeconds) {
  const std::string headset = "udp://192.168.1.9:9001", stranger = "udp://192.168.1.66:9001";
  const std::vector<take::LogEntry> entries =
      with(resting_performance(14).entries,
           {asked_by_osc(15.9, headset, 0), asked_by_osc(16, headset), asked_by_osc(16.1, headset),
            asked_by_osc(20.9, stranger), asked_by_osc(21.1, headset), asked_by_osc(21.2, stranger)});
  std::vector<Watching::Seen> seen;
  const auto session = watched_session(seen);
  const Played run = test::run(*session, entries);
  std::vector<Json> asked;
  for (const take::Event& event : run.events)
    if (event.kind == "recentre") asked.push_back(Json::parse(event.json)["source"]);
  EXPECT_EQ(asked, (std::vector<Json>{headset, headset}));
  EXPECT_EQ(run.count("rested"), 2u);
  ASSERT_EQ(session->versions().size(), 3u);
  EXPECT_EQ(session->versions()[2].origin, "recentre");

  // In the log it is a datagram like others, and a replay obeys it.
  const auto again = watched_session(seen);
  Peers peers;
  std::size_t entry = 0;
  for (const Played::Frame& f : run.frames) {
    for (; entry < static_cast<std::size_t>(f.tick.after_entry); ++entry)
      again->receive(run.log[entry].arrival, peers.of(run.log[entry].source), run.log[entry].bytes);
    again->tick(f.tick.frame, f.tick.fired);
  }
  EXPECT_EQ(again->hash(), run.hash);
}

TEST(RecentreSession, IsRefusedWithinAGuidedCalibration) {
  std::vector<Watching::Seen> seen;
  const auto session = watched_session(seen);
  ASSERT_TRUE(session->command(HostTime(), R"({"command": "calibrate", "kind": "short"})"));
  const auto refused = session->command(HostTime(), kRecentre);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().what, "a guided calibration is running");
}

TEST(RecentreSession, ADatagramDisturbsNoGuidedCalibration) {
  const std::vector<take::LogEntry> entries =
      with(resting_performance(14).entries, {asked_by_osc(16, "udp://192.168.1.9:9001")});
  std::vector<Watching::Seen> seen;
  const Played run =
      test::run(*watched_session(seen), entries, {{15, R"({"command": "calibrate", "kind": "short"})"}});
  EXPECT_EQ(run.count("recentre"), 0u);
}

}  // namespace
}  // namespace mien::session::recentre_session_test
