#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mien/imu/imu_tracker.h"
#include "mien/imu/packets/node_protocol.h"
#include "mien/imu/packets/slimevr_protocol.h"
#include "mien/performer/prologue.h"
#include "mien/session/session.h"
#include "mien/virtual/imu/imu_session.h"
#include "tests/virtual/three_sensors.h"

// A live session without sockets: a virtual performer's packets, arriving when and as they arrive.
namespace mien::session::test {

/// A model that can be checked by hand: the jaw from the chin's turn, the left smile from the cheek's.
/// The left inner brow is read at a constant weight.
class TwoShapes final : public tracker::FrameModel {
 public:
  explicit TwoShapes(float brow = 0) : brow_(brow) {}
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    out = {};
    out.time = features.time;
    const auto weight = [&](std::size_t sensor, double slope) {
      const model::SensorFeature& f = features.sensors[sensor];
      if (!f.has_rotation) return 0.0F;
      const Quat q(f.rotation[0], f.rotation[1], f.rotation[2], f.rotation[3]);
      return static_cast<float>(std::clamp(std::abs(std::tan(log_rotation(q).x())) / slope, 0.0, 1.0));
    };
    out.weights[face::shape("jawOpen")] = weight(0, 0.3);
    out.weights[face::shape("mouthSmile_L")] = weight(1, 0.5);
    out.weights[face::shape("browInnerUp_L")] = brow_;
    const auto there = std::ranges::count_if(features.sensors, &model::SensorFeature::has_rotation);
    out.provenance.fill(there > 0 ? face::Provenance::measured : face::Provenance::predicted);
    out.confidence.fill(static_cast<float>(there) / static_cast<float>(features.sensors.size()));
    out.head = features.head;
    out.head_provenance = features.has_head ? face::Provenance::measured : face::Provenance::predicted;
    out.head_confidence = features.has_head ? 1 : 0;
  }
  void reset() override {}

 private:
  float brow_;
};

inline std::unique_ptr<Session> session(const sensor::Rig& rig = virt::test::three_sensors(),
                                        float brow = 0) {
  Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(rig, std::make_unique<TwoShapes>(brow)));
  parts.protocols.push_back(std::make_unique<imu::NodeProtocol>(imu::NodeProtocol::create().value()));
  parts.protocols.push_back(std::make_unique<imu::SlimeVrProtocol>());
  return Session::create(std::move(parts)).value();
}

/// A performer of `seconds` after a short prologue, and what the nodes' packets would be.
inline virt::VirtualSession performance(double seconds, std::uint64_t seed = 11,
                                        performer::PrologueKind prologue = performer::PrologueKind::brief) {
  const performer::PrologueMotion motion =
      performer::with_prologue(virt::test::talking(static_cast<int>(60 * seconds)), prologue, Random(3));
  virt::DeviceFaults faults = virt::test::mild_faults();
  faults.packet_loss = 0;
  return virt::play_devices(motion, virt::test::three_sites(), virt::test::three_sensors(), faults,
                            Random(seed))
      .value();
}

/// When the short prologue is over, s: neutral, nod, shake, ease.
inline constexpr double kPrologue_s = 3 + 4.5 + 4.5 + 0.5;

struct Played {
  struct Frame {
    take::Tick tick;
    face::OutputFrame frame;
  };
  std::vector<Frame> frames;
  std::vector<take::Event> events;
  std::vector<take::LogEntry> log;  // What a recorder would have kept.
  std::string hash;
  Report report;
  [[nodiscard]] std::size_t count(const std::string& kind) const {
    return static_cast<std::size_t>(std::ranges::count(events, kind, &take::Event::kind));
  }
};

/// A command of the page at a time.
struct Order {
  double at_s = 0;
  std::string json;
};

/// Feeds a session as the live loop does: entries by arrival, ticks as they are due, deadlines between.
inline Played run(Session& session, const std::vector<take::LogEntry>& entries,
                  std::vector<Order> orders = {}, double beyond_s = 0) {
  Played out;
  Peers peers;
  const auto fire = [&](HostTime now) {
    while (const auto tick = session.due(now)) {
      const face::OutputFrame& frame = session.tick(tick->frame, tick->fired);
      out.frames.push_back(
          {{tick->index, static_cast<std::int64_t>(out.log.size()), tick->fired, tick->frame}, frame});
      for (take::Event& event : session.take_events()) out.events.push_back(std::move(event));
    }
  };
  const auto obey_until = [&](HostTime now) {
    while (!orders.empty() && HostTime(from_seconds(orders.front().at_s)) <= now) {
      const HostTime at(from_seconds(orders.front().at_s));
      fire(at);
      const std::string& json = orders.front().json;
      const auto done = session.command(at, json);
      EXPECT_TRUE(done) << json << ": " << (done ? "" : done.error().message());
      const auto bytes = std::as_bytes(std::span(json));
      out.log.push_back({static_cast<std::int64_t>(out.log.size()) + 1,
                         at,
                         std::string(kPageSource),
                         {bytes.begin(), bytes.end()}});
      orders.erase(orders.begin());
    }
  };
  HostTime newest{};
  for (const take::LogEntry& entry : entries) {
    // Deadlines are looked at between arrivals, as the loop's timer does.
    while (session.deadline() && *session.deadline() < entry.arrival) {
      obey_until(*session.deadline());
      fire(*session.deadline());
    }
    obey_until(entry.arrival);
    fire(entry.arrival);
    const Session::Received received = session.receive(entry.arrival, peers.of(entry.source), entry.bytes);
    if (received.verdict == sensor::Verdict::taken || received.verdict == sensor::Verdict::ignored)
      out.log.push_back({static_cast<std::int64_t>(out.log.size()) + 1,
                         entry.arrival,
                         entry.source,
                         {received.log.begin(), received.log.end()}});
    fire(entry.arrival);
    newest = entry.arrival;
  }
  const HostTime end = newest + from_seconds(beyond_s);
  while (session.deadline() && *session.deadline() < end) {
    obey_until(*session.deadline());
    fire(*session.deadline());
  }
  session.report(end, out.report);
  out.hash = session.hash();
  return out;
}

/// Entries from one node only, or from all others.
inline std::vector<take::LogEntry> without(const virt::VirtualSession& performed, std::uint16_t sensor,
                                           double from_s, double to_s) {
  std::vector<take::LogEntry> out;
  std::map<std::int64_t, std::uint16_t> of;
  for (const take::StoredSample& s : performed.samples) of[s.entry] = s.sample.sensor;
  for (const take::LogEntry& entry : performed.entries) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    if (of[entry.id] == sensor && t >= from_s && t < to_s) continue;
    out.push_back(entry);
  }
  return out;
}

/// Every weight finite and in [0, 1], every frame a 60th after the last, none left out.
inline void expect_sound(const Played& run) {
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const auto& [tick, frame] = run.frames[i];
    ASSERT_EQ(tick.frame, DeviceTime(frame_offset(tick.index)));
    if (i > 0) {
      ASSERT_EQ(tick.index, run.frames[i - 1].tick.index + 1);
    }
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      ASSERT_TRUE(std::isfinite(frame.weights[k]));
      ASSERT_GE(frame.weights[k], 0);
      ASSERT_LE(frame.weights[k], 1);
      ASSERT_GE(frame.confidence[k], 0);
      ASSERT_LE(frame.confidence[k], 1);
    }
    ASSERT_NEAR(frame.head.norm(), 1, 1e-6);
  }
}

/// The largest change of any weight from one frame to the next, from a time on.
inline double largest_step(const Played& run, double from_s = 0) {
  float largest = 0;
  for (std::size_t i = 1; i < run.frames.size(); ++i) {
    if (to_seconds(run.frames[i].tick.fired.time_since_epoch()) < from_s) continue;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      largest =
          std::max(largest, std::abs(run.frames[i].frame.weights[k] - run.frames[i - 1].frame.weights[k]));
  }
  return largest;
}

}  // namespace mien::session::test
