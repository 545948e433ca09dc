// Smart eyewear as a second modality of the live session, which knows it only as a tracker and a protocol.
#include "mien/session/session.h"

#include <gtest/gtest.h>

#include <iostream>

#include "mien/eyewear/packet.h"
#include "mien/face/anchors.h"
#include "tests/session/eyewear_session.h"
#include "tests/session/session_run.h"

namespace mien::session::eyewear_session_test {
namespace {

using face::Provenance;
using face::shape;
using test::kPrologue_s;
using test::Played;

const std::size_t kJaw = shape("jawOpen");

double fired_s(const Played::Frame& frame) {
  return to_seconds(frame.tick.fired.time_since_epoch());
}

const virt::VirtualSession& performed() {
  static const virt::VirtualSession session = test::worn_performance(6);
  return session;
}

/// The packets as they are, but that these channels of a board see nothing between two moments: blinded.
std::vector<take::LogEntry> blinded(std::size_t channels, double from_s, double to_s) {
  std::vector<take::LogEntry> out = performed().entries;
  for (take::LogEntry& entry : out) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    if (t < from_s || t >= to_s) continue;
    eyewear::Packet packet = eyewear::parse_packet(entry.bytes).value();
    for (std::size_t c = 0; c < std::min<std::size_t>(channels, packet.channels); ++c)
      packet.light[c] = {packet.full_scale(), packet.full_scale()};
    entry.bytes = eyewear::encode_packet(packet).value();
  }
  return out;
}

TEST(EyewearSession, FindsItsNeutralAndFollowsTheJaw) {
  const auto session = test::eyewear_session();
  EXPECT_EQ(session->modality(), "eyewear");
  const Played run = test::run(*session, performed().entries);
  test::expect_sound(run);
  ASSERT_EQ(session->versions().size(), 1u);
  EXPECT_EQ(session->versions()[0].origin, "self");
  EXPECT_FALSE(session->versions()[0].scores.empty());
  EXPECT_EQ(run.report.calibration.state, "done");
  EXPECT_EQ(run.count("neutral"), 1u) << "the hold that it found is an event of the take";
  // Nor does a broad, open jaw bring the two sensors beneath it to the end of their range.
  for (std::size_t i = 0; i < run.report.links.size(); ++i)
    EXPECT_EQ(run.report.links[i].health.state, sensor::LinkState::good) << i;
  double square = 0;
  std::size_t count = 0;
  for (const Played::Frame& f : run.frames) {
    if (fired_s(f) < kPrologue_s + 0.5) continue;
    EXPECT_EQ(f.frame.provenance[kJaw], Provenance::measured);
    EXPECT_EQ(f.frame.head_provenance, Provenance::neutral);
    const auto truth = std::ranges::find(performed().truth, f.tick.frame, &take::TruthFrame::time);
    ASSERT_NE(truth, performed().truth.end());
    const double error = f.frame.weights[kJaw] - truth->weights[kJaw];
    square += error * error;
    ++count;
  }
  const double rms = std::sqrt(square / static_cast<double>(count));
  std::cout << "jawOpen: " << rms << " RMS off the truth\n";
  EXPECT_LT(rms, 0.25) << "a straight line through a curve that is none";
}

TEST(EyewearSession, TheSameLogGivesTheSameBits) {
  const std::vector<test::Order> orders = {{4, R"({"command": "calibrate", "kind": "short"})"},
                                           {14, R"({"command": "recentre"})"}};
  const Played live = test::run(*test::eyewear_session(), performed().entries, orders);
  const auto session = test::eyewear_session();
  std::size_t entry = 0;
  for (const Played::Frame& f : live.frames) {
    for (; entry < static_cast<std::size_t>(f.tick.after_entry); ++entry) {
      const take::LogEntry& e = live.log[entry];
      if (e.source == kPageSource) {
        EXPECT_TRUE(
            session->command(e.arrival, {reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size()}));
      } else {
        session->receive(e.arrival, 0, e.bytes);
      }
    }
    session->tick(f.tick.frame, f.tick.fired);
  }
  EXPECT_EQ(session->hash(), live.hash);
}

TEST(EyewearSession, AGuidedCalibrationAsksForNeutralAloneAndAFullOneForExpressionsToo) {
  const auto session = test::eyewear_session();
  const Played run =
      test::run(*session, performed().entries, {{3, R"({"command": "calibrate", "kind": "short"})"}});
  ASSERT_EQ(session->versions().size(), 2u);
  EXPECT_EQ(session->versions()[1].origin, "guided");
  // A second and a half to read, then five.
  EXPECT_NEAR(to_seconds(session->versions()[1].made - session->versions()[0].made), 1 + 1.5 + 5, 0.2);
  EXPECT_NE(session->versions()[1].json, session->versions()[0].json);

  const auto full = test::eyewear_session();
  const Played led =
      test::run(*full, performed().entries, {{3, R"({"command": "calibrate", "kind": "full"})"}});
  EXPECT_EQ(led.report.calibration.state, "running");
  EXPECT_EQ(led.report.calibration.steps, 1 + face::anchors().size());
  EXPECT_EQ(led.report.calibration.step, "anchor");
  ASSERT_TRUE(led.report.calibration.target);
}

TEST(EyewearSession, SensorsThatDieAreSeenAndTheFaceDoesNotJump) {
  const double lost_s = kPrologue_s + 2, back_s = lost_s + 2;
  for (const std::size_t channels : {1u, 3u, 4u}) {
    const auto session = test::eyewear_session();
    const Played run = test::run(*session, blinded(channels, lost_s, back_s));
    test::expect_sound(run);
    const double share = 1 - 2.0 * static_cast<double>(channels) / 20;  // Of both boards.
    const float sure = share >= 0.75 ? 1 : 0.5F;                        // As the regressor's table has it.
    for (const Played::Frame& f : run.frames) {
      const double t = fired_s(f);
      if (t > lost_s + 0.15 && t < back_s) {
        EXPECT_EQ(f.frame.confidence[kJaw], sure) << t;
      }
      if (t > back_s + 0.5) {
        EXPECT_EQ(f.frame.confidence[kJaw], 1) << t;
      }
    }
    const double step = test::largest_step(run, kPrologue_s);
    std::cout << channels << " channels of each board blinded: largest step " << step << '\n';
    EXPECT_LE(step, 0.5);
  }
}

TEST(EyewearSession, AllLostHoldsEasesToNeutralAndComesBack) {
  const double lost_s = kPrologue_s + 2.3, back_s = lost_s + 2;
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : performed().entries) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    if (t < lost_s || t >= back_s) entries.push_back(entry);
  }
  const auto session = test::eyewear_session();
  const Played run = test::run(*session, entries);
  test::expect_sound(run);
  EXPECT_EQ(run.count("sensor_lost"), 20u);
  EXPECT_EQ(run.count("sensor_back"), 20u);
  bool held = false, eased = false;
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    held = held || f.frame.provenance[kJaw] == Provenance::held;
    if (t > back_s - 0.3 && t < back_s) eased = eased || f.frame.weights[kJaw] < 0.05F;
    if (t > back_s + 0.7) {
      EXPECT_EQ(f.frame.provenance[kJaw], Provenance::measured) << t;
    }
  }
  EXPECT_TRUE(held);
  EXPECT_TRUE(eased);
  EXPECT_LE(test::largest_step(run, kPrologue_s), 0.5);
}

}  // namespace
}  // namespace mien::session::eyewear_session_test
