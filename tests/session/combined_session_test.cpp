#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "mien/eyewear/eyewear_protocol.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig_part.h"
#include "tests/session/session_run.h"

// IMUs and glasses in one session: each on its own clock, one answer.
namespace mien::session::combined_session_test {
namespace {

using face::Provenance;
using face::shape;
using test::kPrologue_s;
using test::Played;

const std::size_t kJaw = shape("jawOpen");
const std::size_t kBrow = shape("browInnerUp_L");

constexpr std::uint64_t kGlasses = 0x024D'4945'5900ULL;
constexpr double kPairRateHz = 230;
/// The glasses' board began 77 s before the session, and its crystal is 40 ppm fast.
constexpr double kBoardBegan_s = 77;
constexpr double kBoardRate = 40e-6;
/// What the light at the brow does, by the session's time.
double light_at(double t_s) {
  return 0.4 + 0.3 * std::sin(2 * std::numbers::pi * 0.5 * t_s);
}

/// Calibrated from the first light on, and anew by each neutral hold, whatever the light; its brow is the
/// light, linear between the samples about the frame.
class OneLight final : public tracker::Tracker {
 public:
  explicit OneLight(std::uint16_t sensor) : sensor_(sensor) {}
  [[nodiscard]] std::string_view modality() const override { return "eyewear"; }
  void add(HostTime, const sensor::Sample& sample) override {
    if (sample.sensor != sensor_) return;
    before_ = newest_;
    newest_ = sample;
  }
  void forget(std::uint16_t) override {}
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines,
                           face::OutputFrame& out) override {
    tracker::TickResult result{.sensors_present = 1, .calibration = {}};
    out = {};
    out.time = frame;
    out.provenance.fill(Provenance::neutral);
    if (neutral_until_ && frame >= *neutral_until_) {
      neutral_until_.reset();
      result.calibration.push_back({.modality = modality(), .found = {}});
    }
    if (!newest_ || !before_ || !lines.ready()) return result;
    const DeviceTime at = lines.from_line(sensor_, frame);
    if (at - newest_->time > std::chrono::milliseconds(100)) {
      result.sensors_present = 0;
      return result;
    }
    const double way = to_seconds(at - before_->time) / to_seconds(newest_->time - before_->time);
    out.weights.values.fill(
        static_cast<float>(before_->values[0] + way * (newest_->values[0] - before_->values[0])));
    out.provenance.fill(Provenance::measured);
    out.confidence.fill(1);
    return result;
  }
  [[nodiscard]] tracker::Guidance guidance() const override { return {}; }
  void guide(tracker::Step step, DeviceTime, DeviceTime end) override {
    if (step == tracker::Step::neutral) neutral_until_ = end;
  }
  void cancel_guidance() override { neutral_until_.reset(); }
  [[nodiscard]] std::string calibration() const override { return R"({"light":1})"; }
  [[nodiscard]] Result<void> restore(std::string_view) override { return {}; }

 private:
  std::uint16_t sensor_;
  std::optional<sensor::Sample> before_, newest_;
  std::optional<DeviceTime> neutral_until_;
};

/// Three IMUs and one light, the frame grid on this sensor's clock.
sensor::Rig mixed_rig(const std::string& reference) {
  sensor::Rig rig = virt::test::three_sensors();
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    rig.sensors[i].device = sensor::format_device({0x024D'4945'4E00ULL + i, 0});
  rig.sensors.push_back({.name = "brow_inner_L",
                         .kind = "eyewear",
                         .site = "brow",
                         .side = 'L',
                         .role = "face",
                         .device = sensor::format_device({kGlasses, 0})});
  rig.reference = reference;
  return rig;
}

std::unique_ptr<Session> session(const sensor::Rig& rig) {
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(
      std::make_unique<imu::ImuTracker>(sensor::part_of(rig, "imu"), std::make_unique<test::TwoShapes>()));
  parts.trackers.push_back(std::make_unique<OneLight>(std::uint16_t{3}));
  parts.protocols.push_back(
      std::make_unique<eyewear::EyewearProtocol>(eyewear::EyewearProtocol::create().value()));
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  return Session::create(std::move(parts)).value();
}

/// The IMUs' packets, and those of the glasses from `begin_s` on but for a gap, by arrival.
std::vector<take::LogEntry> with_glasses(const virt::VirtualSession& imus, double begin_s = 0,
                                         double gap_begin_s = 1e9, double gap_end_s = 1e9) {
  std::vector<take::LogEntry> entries = imus.entries;
  const double end_s = to_seconds(entries.back().arrival.time_since_epoch());
  Random random(8);
  std::int64_t id = entries.back().id;
  for (std::uint32_t n = 0; n / kPairRateHz < end_s; ++n) {
    const double t = n / kPairRateHz;
    const double delay_s = 0.001 + random.uniform(0, 0.003);
    if (t < begin_s || (t >= gap_begin_s && t < gap_end_s)) continue;
    eyewear::Packet packet;
    packet.channels = 1;
    packet.adc_bits = 16;
    packet.device = kGlasses;
    packet.sequence = n;
    packet.time =
        DeviceTime(std::chrono::microseconds(std::llround(1e6 * (kBoardBegan_s + t * (1 + kBoardRate)))));
    packet.light[0].on = static_cast<std::uint16_t>(std::lround(65535 * light_at(t)));
    entries.push_back({++id, HostTime(from_seconds(t + delay_s)), "udp://10.0.0.7:1",
                       eyewear::encode_packet(packet).value()});
  }
  std::ranges::sort(entries, {},
                    [](const take::LogEntry& e) { return std::tuple(e.arrival, e.source, e.id); });
  return entries;
}

double fired_s(const Played::Frame& frame) {
  return to_seconds(frame.tick.fired.time_since_epoch());
}

/// Each device's clock is mapped onto the grid's, whichever carries it: the brow is the light's, the jaw the
/// performer's, both by their own true times.
void expect_both_on_the_grid(const std::string& reference) {
  const virt::VirtualSession performed = test::performance(8);
  const sensor::Rig rig = mixed_rig(reference);
  const auto both = session(rig);
  const Played run = test::run(*both, with_glasses(performed));
  test::expect_sound(run);
  EXPECT_EQ(run.report.calibration.state, "done");

  // The truth by the session's time: the performer's clock is the ear's, whose way to the host's the tracker
  // of IMUs alone knows.
  sensor::TimeLines ear(rig.sensors.size(), rig.find("mastoid_L"));
  for (const take::StoredSample& stored : performed.samples) {
    const auto entry = std::ranges::find(performed.entries, stored.entry, &take::LogEntry::id);
    ear.add(entry->arrival, stored.sample);
  }
  const bool by_ear = reference == "mastoid_L";
  double jaw = 0, brow = 0;
  std::size_t count = 0;
  for (const Played::Frame& f : run.frames) {
    if (fired_s(f) < kPrologue_s + 0.5) continue;
    ASSERT_EQ(f.frame.provenance[kJaw], Provenance::measured);
    ASSERT_EQ(f.frame.provenance[kBrow], Provenance::measured);
    const double frame_s = to_seconds(f.tick.frame.time_since_epoch());
    // When the frame was, by the session's time: both ways know it to a millisecond or so.
    const double t = by_ear ? to_seconds(ear.to_host(f.tick.frame).time_since_epoch()) - 0.0015
                            : (frame_s - kBoardBegan_s) / (1 + kBoardRate);
    brow += std::pow(f.frame.weights[kBrow] - light_at(t), 2);
    const DeviceTime by_performer = by_ear ? f.tick.frame : ear.from_host(HostTime(from_seconds(t + 0.0015)));
    const auto after = std::ranges::lower_bound(performed.truth, by_performer, {}, &take::TruthFrame::time);
    ASSERT_NE(after, performed.truth.end());
    const auto before = after == performed.truth.begin() ? after : after - 1;
    const double way = after == before
                           ? 0
                           : to_seconds(by_performer - before->time) / to_seconds(after->time - before->time);
    const double truth = before->weights[kJaw] + way * (after->weights[kJaw] - before->weights[kJaw]);
    jaw += std::pow(f.frame.weights[kJaw] - truth, 2);
    ++count;
  }
  ASSERT_GT(count, 400u);
  const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(count)); };
  std::cout << reference << ": jaw " << rms(jaw) << ", brow " << rms(brow) << " RMS\n";
  EXPECT_LT(rms(jaw), 0.12) << "as IMUs alone do";
  EXPECT_LT(rms(brow), 0.01) << "the light moves by 0.94 a second: 10 ms";
}

TEST(CombinedSession, GlassesAreBroughtOntoTheGridOfAnImu) {
  expect_both_on_the_grid("mastoid_L");
}

TEST(CombinedSession, ImusAreBroughtOntoTheGridOfTheGlasses) {
  expect_both_on_the_grid("brow_inner_L");
}

TEST(CombinedSession, TheImusAnswerAsTheyDoAlone) {
  // With the grid on their own clock the IMUs' part of the answer keeps its bits.
  const virt::VirtualSession performed = test::performance(4);
  const Played alone = test::run(*test::session(), performed.entries);
  const Played both = test::run(*session(mixed_rig("mastoid_L")), with_glasses(performed));
  std::size_t compared = 0;
  for (const Played::Frame& f : both.frames) {
    const auto same =
        std::ranges::find(alone.frames, f.tick.frame, [](const Played::Frame& a) { return a.tick.frame; });
    // A frame that fires later, since it waits for the glasses, may know more.
    if (same == alone.frames.end() || same->tick.fired != f.tick.fired) continue;
    if (fired_s(f) < kPrologue_s + 0.5) continue;
    ASSERT_EQ(f.frame.weights[kJaw], same->frame.weights[kJaw]) << fired_s(f);
    ++compared;
  }
  EXPECT_GT(compared, 20u);
}

TEST(CombinedSession, GlassesThatDropOutAreReplacedAndComeBackSoftly) {
  const virt::VirtualSession performed = test::performance(8);
  const double lost_s = kPrologue_s + 2.2, back_s = lost_s + 2;
  const auto both = session(mixed_rig("mastoid_L"));
  const Played run = test::run(*both, with_glasses(performed, 0, lost_s, back_s));
  test::expect_sound(run);
  EXPECT_EQ(run.count("sensor_lost"), 1u);
  EXPECT_EQ(run.count("sensor_back"), 1u);
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    if (t < kPrologue_s + 0.5) continue;
    ASSERT_EQ(f.frame.provenance[kJaw], Provenance::measured) << "the IMUs are there";
    if (t > lost_s + 1.1 && t < back_s) {
      EXPECT_EQ(f.frame.weights[kBrow], 0) << "TwoShapes knows no brow";
    }
    if (t > back_s + 1) {
      EXPECT_NEAR(f.frame.weights[kBrow], light_at(t), 0.05);
    }
  }
  // Besides the hand-over of at most 0.07 the face itself moves by up to 0.08 a frame (1.5 Hz).
  EXPECT_LT(test::largest_step(run, kPrologue_s), 0.2);
}

TEST(CombinedSession, WhatOneTrackerMadeOfAGuidedCalibrationThatFailedForAnotherIsAVersion) {
  // Nobody nods: the IMUs keep what they had, and the glasses have a new neutral.
  const virt::VirtualSession performed = test::performance(18);
  const std::vector<test::Order> orders = {{kPrologue_s + 1, R"({"command": "calibrate", "kind": "short"})"}};
  const Played both = test::run(*session(mixed_rig("mastoid_L")), with_glasses(performed), orders);
  EXPECT_EQ(both.count("calibration_failed"), 1u);
  EXPECT_EQ(both.report.calibration.state, "failed");
  ASSERT_GE(both.report.calibration.versions.size(), 2u);
  EXPECT_EQ(both.report.calibration.versions.back().origin, "guided");
  EXPECT_EQ(both.report.calibration.in_force, both.report.calibration.versions.back().id);

  const Played alone = test::run(*test::session(), performed.entries, orders);
  EXPECT_EQ(alone.count("calibration_failed"), 1u);
  for (const auto& version : alone.report.calibration.versions) EXPECT_NE(version.origin, "guided");
}

TEST(CombinedSession, TheSameLogGivesTheSameBitsAndThePageChoosesWhoAnswers) {
  const virt::VirtualSession performed = test::performance(3);
  const std::vector<take::LogEntry> entries = with_glasses(performed, 1);
  const std::vector<test::Order> orders = {
      {kPrologue_s + 1, R"({"command": "shape", "merge": {"order": {"jaw": ["eyewear"]}}})"}};
  const Played first = test::run(*session(mixed_rig("brow_inner_L")), entries, orders);
  const Played again = test::run(*session(mixed_rig("brow_inner_L")), entries, orders);
  EXPECT_EQ(first.hash, again.hash);
  EXPECT_NE(first.report.shaping.find("merge"), std::string::npos);
  for (const Played::Frame& f : first.frames) {
    if (fired_s(f) > kPrologue_s + 2) {
      ASSERT_EQ(f.frame.weights[kJaw], f.frame.weights[kBrow]);
    }
  }
}

}  // namespace
}  // namespace mien::session::combined_session_test
