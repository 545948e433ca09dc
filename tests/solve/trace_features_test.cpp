#include "mien/solve/trace_features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mien/modalities/modalities.h"
#include "mien/virtual/stage.h"
#include "tests/folder.h"
#include "tests/project_path.h"
#include "tests/solve/performed_take.h"

namespace mien::solve::trace_features_test {
namespace {

std::vector<model::FeatureFrame> trace(const virt::VirtualSession& session) {
  return trace_features(virt::test::three_sensors(), session.events, session.entries, session.ticks).value();
}

double error_rad(const model::SensorFeature& feature, std::size_t sensor, const take::TruthFrame& truth) {
  const auto& q = feature.rotation;
  return virt::test::three_sites()[sensor]
      .rotation(truth.weights)
      .angularDistance(Quat(q[0], q[1], q[2], q[3]));
}

TEST(TraceFeatures, GivesOneFrameATick) {
  const virt::VirtualSession session = test::lab_session(0);
  const auto frames = trace(session);
  ASSERT_EQ(frames.size(), session.ticks.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].time, session.ticks[i].frame);
    ASSERT_EQ(frames[i].sensors.size(), 2U);
    for (std::size_t s = 0; s < 2; ++s) {
      ASSERT_TRUE(frames[i].sensors[s].has_rotation);
      EXPECT_FALSE(frames[i].sensors[s].has_accel);
      EXPECT_LT(error_rad(frames[i].sensors[s], s, session.truth[i]), 1e-5);
    }
    EXPECT_FALSE(frames[i].has_head);
  }
}

TEST(TraceFeatures, ThePrologueCalibratesDevices) {
  const virt::VirtualSession session = test::device_session();
  const auto frames = trace(session);
  ASSERT_EQ(frames.size(), session.ticks.size());
  double square = 0;
  double count = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!session.truth[i].evaluated) continue;
    for (std::size_t s = 0; s < 2; ++s) {
      ASSERT_TRUE(frames[i].sensors[s].has_rotation && frames[i].sensors[s].has_accel);
      square += std::pow(error_rad(frames[i].sensors[s], s, session.truth[i]), 2);
      ++count;
    }
    EXPECT_TRUE(frames[i].has_head);
  }
  EXPECT_LT(std::sqrt(square / count), 1.5 * std::numbers::pi / 180);
}

TEST(TraceFeatures, APrologueThatNobodyNamesIsFound) {
  virt::VirtualSession session = test::device_session();
  session.events.clear();
  const auto frames = trace(session);
  EXPECT_FALSE(frames.front().sensors[0].has_rotation);
  EXPECT_TRUE(frames.back().sensors[0].has_rotation) << "the nod was seen, as live";
  const imu::PipelineSettings settings;  // Which do not look for one.
  const auto unfound =
      trace_features(virt::test::three_sensors(), session.events, session.entries, session.ticks, settings)
          .value();
  for (const model::FeatureFrame& frame : unfound)
    for (const model::SensorFeature& sensor : frame.sensors) ASSERT_FALSE(sensor.has_rotation);
}

TEST(TraceFeatures, OfARecordedTakeAreThoseOfItsSessionWhateverItWasGuidedThrough) {
  virt::StageRequest request;
  request.rig = project_path("rigs/default.toml");
  request.script = performer::default_script(performer::Block::reading, 4);
  request.prologue = performer::PrologueKind::guided;
  const virt::Stage stage = virt::set_stage(request).value();
  const virt::VirtualSession performed = virt::play(stage).value();
  const auto session = modalities::make_session(stage.rig, project_path("models/live.safetensors")).value();

  const mien::test::Folder folder;
  const auto path = folder / "recorded.mien";
  auto writer = take::TakeWriter::create(path, {.devices = "live", .rig_toml = stage.rig_toml}, true).value();
  const std::string command = R"({"command": "calibrate", "kind": "wearer"})";
  const HostTime begin = performed.entries.front().arrival;
  ASSERT_TRUE(session->command(begin, command));
  writer.add_entry(begin, "page", std::as_bytes(std::span(command)));
  std::vector<model::FeatureFrame> seen;
  std::int64_t last = 1;
  for (const take::LogEntry& entry : performed.entries) {
    const auto fire = [&] {
      while (const auto due = session->due(entry.arrival)) {
        session->tick(due->frame, due->fired);
        writer.add_tick({due->index, last, due->fired, due->frame});
        seen.push_back(*session->features());
      }
    };
    fire();
    session->receive(entry.arrival, 0, entry.bytes);
    last = writer.add_entry(entry.arrival, entry.source, entry.bytes);
    fire();
  }
  for (const take::Event& event : session->take_events()) writer.add_event(event);
  ASSERT_TRUE(writer.finish());

  ASSERT_TRUE(seen.back().sensors.front().has_rotation) << "it was calibrated";
  const auto traced = take_features(take::Take::open(path).value()).value();
  ASSERT_EQ(traced.size(), seen.size());
  for (std::size_t f = 0; f < traced.size(); ++f) {
    ASSERT_EQ(traced[f].time, seen[f].time);
    for (std::size_t s = 0; s < traced[f].sensors.size(); ++s) {
      ASSERT_EQ(traced[f].sensors[s].has_rotation, seen[f].sensors[s].has_rotation) << f;
      ASSERT_EQ(traced[f].sensors[s].rotation, seen[f].sensors[s].rotation) << f;
    }
  }
}

}  // namespace
}  // namespace mien::solve::trace_features_test
