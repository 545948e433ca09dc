#include "mien/session/session.h"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <iostream>
#include <iterator>
#include <tuple>

#include "mien/mocap/marker_packet.h"
#include "mien/mocap/marker_protocol.h"
#include "mien/shaping/resting_face.h"
#include "tests/session/session_run.h"

namespace mien::session::session_test {
namespace {

using face::Provenance;
using face::shape;
using test::kPrologue_s;
using test::performance;
using test::Played;

const std::size_t kJaw = shape("jawOpen");

double fired_s(const Played::Frame& frame) {
  return to_seconds(frame.tick.fired.time_since_epoch());
}

TEST(Session, CalibratesItselfAndTracks) {
  const virt::VirtualSession performed = performance(6);
  const auto session = test::session();
  const Played run = test::run(*session, performed.entries);
  test::expect_sound(run);
  ASSERT_EQ(session->versions().size(), 1u);
  EXPECT_EQ(session->versions()[0].origin, "self");
  EXPECT_EQ(run.report.calibration.state, "done");
  EXPECT_EQ(run.count("neutral"), 1u) << "the steps found are events of the take";
  EXPECT_EQ(run.count("shake"), 1u);

  double square = 0;
  std::size_t count = 0;
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    if (t < 6.5) {
      EXPECT_EQ(f.frame.provenance[kJaw], Provenance::neutral) << t;
      EXPECT_EQ(f.frame.weights[kJaw], 0) << t;
    }
    if (t < kPrologue_s + 0.5) continue;
    EXPECT_EQ(f.frame.provenance[kJaw], Provenance::measured);
    // The truth of this performer's own time: 1.5 Hz from its start.
    const auto truth = std::ranges::find(performed.truth, f.tick.frame, &take::TruthFrame::time);
    ASSERT_NE(truth, performed.truth.end());
    const double error = f.frame.weights[kJaw] - truth->weights[kJaw];
    square += error * error;
    ++count;
  }
  const double rms = std::sqrt(square / static_cast<double>(count));
  std::cout << "jawOpen: " << rms << " RMS off the truth\n";
  EXPECT_LT(rms, 0.12);
}

TEST(Session, TheSameLogGivesTheSameBits) {
  const virt::VirtualSession performed = performance(6);
  const std::vector<test::Order> orders = {{6, R"({"command": "shape", "smoothing": 0.3, "resting": true})"},
                                           {14, R"({"command": "recentre"})"}};
  const Played live = test::run(*test::session(), performed.entries, orders);
  // As a replay does it: the log's entries and ticks, and nothing of time passing.
  for (int again = 0; again < 3; ++again) {
    const auto session = test::session();
    Peers peers;
    std::size_t entry = 0;
    for (const Played::Frame& f : live.frames) {
      for (; entry < static_cast<std::size_t>(f.tick.after_entry); ++entry) {
        const take::LogEntry& e = live.log[entry];
        if (e.source == kPageSource) {
          EXPECT_TRUE(
              session->command(e.arrival, {reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size()}));
        } else {
          session->receive(e.arrival, peers.of(e.source), e.bytes);
        }
      }
      session->tick(f.tick.frame, f.tick.fired);
    }
    EXPECT_EQ(session->hash(), live.hash);
  }
}

TEST(Session, PromptsChangeNoWeightAndAreTheSameEventsAgain) {
  const virt::VirtualSession performed = performance(8);
  const std::vector<test::Order> orders = {
      {1, R"({"command": "prompt", "name": "rest", "seconds": 2})"},
      {1, R"({"command": "prompt", "name": "smile", "seconds": 2, "target": {"mouthSmile_L": 1}})"},
      {1, R"({"command": "prompt", "name": "no", "seconds": 4})"},
      {1, R"({"command": "prompt", "name": "open", "seconds": 2, "target": {"jawOpen": 0.25}})"},
      {10, R"({"command": "prompts", "do": "skip"})"}};
  const Played plain = test::run(*test::session(), performed.entries);
  const Played asked = test::run(*test::session(), performed.entries, orders);
  EXPECT_EQ(asked.hash, plain.hash);
  ASSERT_EQ(asked.count("prompt"), 3u);
  EXPECT_EQ(asked.report.prompts.state, "over");
  std::vector<take::Event> prompts;
  std::ranges::copy_if(asked.events, std::back_inserter(prompts),
                       [](const take::Event& event) { return event.kind == "prompt"; });
  EXPECT_EQ(prompts[0].end - prompts[0].begin, std::chrono::seconds(2));
  EXPECT_EQ(prompts[1].begin, prompts[0].end);
  EXPECT_EQ(prompts[1].json, R"({"name": "smile", "target": {"mouthSmile_L": 1}})");
  EXPECT_EQ(prompts[2].json, R"({"name": "open", "target": {"jawOpen": 0.25}})") << "one was skipped";

  const Played again = test::run(*test::session(), performed.entries, orders);
  ASSERT_EQ(again.events.size(), asked.events.size());
  for (std::size_t i = 0; i < again.events.size(); ++i) {
    EXPECT_EQ(again.events[i].begin, asked.events[i].begin);
    EXPECT_EQ(again.events[i].json, asked.events[i].json);
  }
}

TEST(Session, ALostSensorIsSeenWithinATenthOfASecondAndIsBackInHalfOfOne) {
  const virt::VirtualSession performed = performance(8);
  const auto session = test::session();
  const double lost_s = kPrologue_s + 3, back_s = lost_s + 2;
  const Played run = test::run(*session, test::without(performed, 0, lost_s, back_s));
  test::expect_sound(run);
  EXPECT_EQ(run.count("sensor_lost"), 1u);
  EXPECT_EQ(run.count("sensor_back"), 1u);
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    if (t > lost_s + 0.15 && t < back_s) {
      EXPECT_LT(f.frame.confidence[kJaw], 0.9F) << t;
    }
    if (t > back_s + 0.5) {
      EXPECT_EQ(f.frame.confidence[kJaw], 1) << t;
    }
  }
  EXPECT_LT(test::largest_step(run, kPrologue_s), 0.2);
}

TEST(Session, AllLostHoldsEasesToNeutralAndComesBack) {
  const virt::VirtualSession performed = performance(8);
  const auto session = test::session();
  const double lost_s = kPrologue_s + 3.3, back_s = lost_s + 2;
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : performed.entries) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    if (t < lost_s || t >= back_s) entries.push_back(entry);
  }
  const Played run = test::run(*session, entries);
  test::expect_sound(run);
  bool held = false;
  for (const Played::Frame& f : run.frames) {
    const double t = fired_s(f);
    held = held || f.frame.provenance[kJaw] == Provenance::held;
    if (t > lost_s + 1.1 && t < back_s) {
      EXPECT_EQ(f.frame.provenance[kJaw], Provenance::neutral) << t;
      EXPECT_LT(f.frame.weights[kJaw], 0.01F) << t;
    }
    if (t > back_s + 0.5) {
      EXPECT_EQ(f.frame.provenance[kJaw], Provenance::measured) << t;
    }
  }
  EXPECT_TRUE(held);
  // The face itself moves by up to 0.08 a frame (1.5 Hz).
  EXPECT_LT(test::largest_step(run, kPrologue_s), 0.2);
}

TEST(Session, ASecondDeviceWithTheSameIdIsNotBelieved) {
  const virt::VirtualSession performed = performance(5);
  const virt::VirtualSession other = performance(5, 77);
  std::vector<take::LogEntry> entries = performed.entries;
  std::map<std::int64_t, std::uint16_t> of;
  for (const take::StoredSample& s : other.samples) of[s.entry] = s.sample.sensor;
  for (const take::LogEntry& entry : other.entries)
    if (of[entry.id] == 0 && entry.arrival > HostTime(from_seconds(kPrologue_s + 1))) {
      entries.push_back(entry);
      entries.back().source = "udp://10.0.0.66:5005";
    }
  std::ranges::sort(entries, {},
                    [](const take::LogEntry& e) { return std::tuple(e.arrival, e.source, e.id); });
  const auto session = test::session();
  const Played run = test::run(*session, entries);
  test::expect_sound(run);
  EXPECT_EQ(run.report.links[0].health.state, sensor::LinkState::duplicate);
  // The first goes on as if nothing were.
  const Played alone = test::run(*test::session(), performed.entries);
  for (std::size_t i = 0; i < std::min(run.frames.size(), alone.frames.size()); ++i)
    ASSERT_EQ(run.frames[i].frame.weights, alone.frames[i].frame.weights) << i;
}

TEST(Session, AGuidedCalibrationScoresAndACancelledOneChangesNothing) {
  // The performer's own prologue comes when the session asks for it.
  const virt::VirtualSession performed = performance(30, 11);
  {
    const auto session = test::session();
    const Played run = test::run(
        *session, performed.entries,
        {{20, R"({"command": "calibrate", "kind": "short"})"}, {23, R"({"command": "cancel_calibration"})"}});
    const Played plain = test::run(*test::session(), performed.entries);
    EXPECT_EQ(run.report.calibration.state, "done");
    EXPECT_EQ(session->versions().size(), 1u);
    EXPECT_EQ(run.hash, plain.hash);
  }
  {
    // A talking face is no neutral: what was in force stays in force.
    const auto session = test::session();
    const Played run =
        test::run(*session, performed.entries, {{16, R"({"command": "calibrate", "kind": "short"})"}});
    EXPECT_EQ(run.report.calibration.state, "failed");
    EXPECT_FALSE(run.report.calibration.prompt.empty());
    EXPECT_EQ(session->versions().size(), 1u);
    EXPECT_EQ(run.report.calibration.in_force, 1);
  }
}

TEST(Session, WithoutACameraThatSeesAnEyeThereIsNoCalibrationOfGaze) {
  const auto refused = test::session()->command(HostTime{}, R"({"command": "calibrate", "kind": "gaze"})");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

TEST(Session, VersionsCanBeUndone) {
  const virt::VirtualSession performed = performance(10);
  const auto session = test::session();
  const Played run = test::run(
      *session, performed.entries,
      {{14, R"({"command": "recentre"})"}, {18, R"({"command": "use_calibration", "version": 1})"}});
  ASSERT_EQ(session->versions().size(), 2u);
  EXPECT_EQ(session->versions()[1].origin, "recentre");
  EXPECT_EQ(run.report.calibration.in_force, 1);
  EXPECT_FALSE(
      session->command(HostTime(from_seconds(100)), R"({"command": "use_calibration", "version": 9})"));
}

TEST(Session, AVersionCarriesTheRestingFaceLearntSoFar) {
  const virt::VirtualSession performed = performance(36);
  const auto session = test::session(virt::test::three_sensors(), 0.25F);
  const Played run = test::run(*session, performed.entries,
                               {{6, R"({"command": "shape", "resting": true})"},
                                {32, R"({"command": "recentre"})"},
                                {36, R"({"command": "use_calibration", "version": 1})"},
                                {37, R"({"command": "recentre"})"},
                                {41, R"({"command": "use_calibration", "version": 2})"},
                                {43, R"({"command": "recentre"})"}});
  ASSERT_EQ(session->versions().size(), 4u);
  const auto resting = [&](std::size_t i) { return session->versions()[i].resting; };
  const std::string nothing = shaping::write_resting_face({});
  EXPECT_EQ(resting(0), nothing);
  EXPECT_NE(resting(1), nothing);
  EXPECT_EQ(resting(2), nothing);  // What the first knew.
  EXPECT_EQ(resting(3), resting(1));
  EXPECT_EQ(run.report.resting, resting(3));  // In force, for people.
  EXPECT_NE(session->versions()[3].resting.find("browInnerUp_L"), std::string::npos);
}

TEST(Session, BindsByRigByPlaceByAnnouncementAndByOrder) {
  const virt::VirtualSession performed = performance(1);
  sensor::Rig rig = virt::test::three_sensors();
  rig.sensors[0].device = "02:00:00:00:00:99";  // Somebody else.
  const auto session = test::session(rig);
  const Played run =
      test::run(*session, performed.entries,
                {{5, R"({"command": "bind", "sensor": "buccinator_L", "device": "02:4D:49:45:4E:01"})"},
                 {5, R"({"command": "bind", "sensor": "mastoid_L", "device": "02:4d:49:45:4e:02"})"}});
  EXPECT_EQ(run.report.links[0].health.state, sensor::LinkState::silent);
  EXPECT_EQ(run.report.links[1].device, "02:4D:49:45:4E:01");
  ASSERT_EQ(run.report.unbound.size(), 1u);
  EXPECT_EQ(run.report.unbound[0].device, "02:4D:49:45:4E:00");

  rig.sensors[1].device = "02:00:00:00:00:99";
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(rig, std::make_unique<test::TwoShapes>()));
  EXPECT_FALSE(Session::create(std::move(parts)));
}

TEST(Session, AnotherBoardBeginsAnewAndTheSameOneDoesNot) {
  const virt::VirtualSession performed = performance(4);
  const double bind_s = kPrologue_s + 2;
  const auto bound = [&](const char* sensor, const char* device) {
    return test::run(
        *test::session(), performed.entries,
        {{bind_s, fmt::format(R"({{"command": "bind", "sensor": "{}", "device": "{}"}})", sensor, device)}});
  };
  const Played plain = test::run(*test::session(), performed.entries);
  const Played same = bound("mentalis", "02:4D:49:45:4E:00");
  EXPECT_EQ(same.hash, plain.hash);

  // A cheek's board goes to the other cheek: it has no neutral there, and the one that was there is gone.
  const Played other = bound("buccinator_L", "02:4D:49:45:4E:00");
  EXPECT_NE(other.hash, plain.hash);
  EXPECT_EQ(other.report.calibration.state, "done");

  // The head's: there is no calibration until the next nod.
  const Played head = bound("mastoid_L", "02:4D:49:45:4E:00");
  EXPECT_EQ(head.report.calibration.state, "watching");
}

TEST(Session, GarbageIsCountedAndChangesNothing) {
  const virt::VirtualSession performed = performance(2);
  std::vector<take::LogEntry> entries;
  Random random(5);
  for (const take::LogEntry& entry : performed.entries) {
    entries.push_back(entry);
    take::LogEntry garbage = entry;
    garbage.source = "udp://10.0.0.9:1";
    for (std::byte& b : garbage.bytes) b = static_cast<std::byte>(random.below(256));
    entries.push_back(garbage);
    garbage.bytes = entry.bytes;
    garbage.bytes[40] ^= std::byte{1};  // The checksum does not match.
    entries.push_back(garbage);
  }
  const Played with = test::run(*test::session(), entries);
  const Played plain = test::run(*test::session(), performed.entries);
  EXPECT_EQ(with.hash, plain.hash);
  EXPECT_EQ(with.report.malformed, 2 * performed.entries.size());
}

TEST(Session, MarkersAreLoggedAndMoveNothing) {
  const virt::VirtualSession performed = performance(2);
  const auto with_markers = [] {
    Session::Parts parts;
    parts.rig = virt::test::three_sensors();
    parts.trackers.push_back(
        std::make_unique<imu::ImuTracker>(parts.rig, std::make_unique<test::TwoShapes>()));
    parts.protocols.push_back(std::make_unique<mocap::MarkerProtocol>());
    parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
    return Session::create(std::move(parts)).value();
  };
  mocap::MarkerPositionsPacket packet;
  packet.device = 7;
  packet.count = 37;
  const std::vector<std::byte> markers = mocap::encode_marker_positions(packet).value();
  std::vector<take::LogEntry> entries;
  for (const take::LogEntry& entry : performed.entries) {
    entries.push_back(entry);
    take::LogEntry seen = entry;
    seen.source = "udp://10.0.0.9:1";
    seen.bytes = markers;
    entries.push_back(seen);
  }
  const Played with = test::run(*with_markers(), entries);
  const Played plain = test::run(*with_markers(), performed.entries);
  EXPECT_EQ(with.hash, plain.hash);
  EXPECT_EQ(with.report.malformed, 0u);
  EXPECT_EQ(with.log.size(), 2 * performed.entries.size());
}

}  // namespace
}  // namespace mien::session::session_test
