// What the pipeline makes of sensors from which nothing comes for a while.
#include <gtest/gtest.h>

#include "mien/core/units.h"
#include "mien/imu/pipeline.h"
#include "tests/imu/clocked_pipeline.h"
#include "tests/imu/nodding_head.h"

namespace mien::imu::pipeline_gaps_test {
namespace {

using testing_head::Entry;
using testing_head::Faults;
using testing_head::play;
using testing_head::record;
using testing_head::Recording;
using testing_head::Script;
using testing_head::still_skin;

TEST(PipelineGaps, LostSensorsAreMissingAndTheOthersAreNot) {
  Script script;
  script.end = 22;
  Recording recording = record(script, Faults{}, 3, 26, still_skin);
  // Sensor 1 from second 14 on; the ear's from 18 to 19.
  std::erase_if(recording.entries, [](const Entry& entry) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    return (entry.samples[0].sensor == 1 && t > 14) || (entry.samples[0].sensor == 3 && t > 18 && t < 19);
  });
  testing_head::ClockedPipeline pipeline(recording.rig);
  std::size_t seen = 0;
  play(recording, script, pipeline,
       [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline& p) {
         if (t < 11) return;
         if (t < 13.9 || (t > 14.2 && t < 17.9)) {
           EXPECT_TRUE(frame.sensors[0].has_rotation);
           EXPECT_EQ(frame.sensors[1].has_rotation, t < 14) << t;
           ++seen;
         }
         if (t > 18.2 && t < 18.9) {
           EXPECT_FALSE(frame.has_head);
           EXPECT_FALSE(frame.sensors[0].has_rotation);
         }
         if (t > 19.3) {
           EXPECT_TRUE(frame.has_head);
           EXPECT_TRUE(frame.sensors[0].has_rotation);
           // What the gap may have done to the heading is said.
           EXPECT_GT(p.status(0).heading_sigma_rad, 0.2 * kRadPerDeg);
         }
       });
  EXPECT_GT(seen, 300u);
  EXPECT_GT(pipeline.status(3).lost, 200u);
}

TEST(PipelineGaps, AGapOfTheEarSensorIsBridgedByTheFaceSensors) {
  Script script;
  script.end = 18;
  Recording recording = record(script, Faults{}, 6, 26, still_skin);
  // The head nods and turns by up to 150 degrees a second all the while.
  std::erase_if(recording.entries, [](const Entry& entry) {
    const double t = to_seconds(entry.arrival.time_since_epoch());
    return entry.samples[0].sensor == 6 && t > 14 && t < 14.6;
  });
  for (const bool bridged : {true, false}) {
    PipelineSettings settings;
    if (!bridged) settings.bridge = {};
    testing_head::ClockedPipeline pipeline(recording.rig, settings);
    std::size_t within = 0, beyond = 0;
    play(recording, script, pipeline,
         [&](double t, const model::FeatureFrame& frame, const testing_head::ClockedPipeline&) {
           if (t > 14.17 && t < 14.23) {
             ++within;
             EXPECT_EQ(frame.has_head, bridged) << t;
             for (const auto& feature : frame.sensors) {
               ASSERT_EQ(feature.has_rotation, bridged) << t;
               EXPECT_FALSE(feature.has_accel) << t;
               const auto& q = feature.rotation;
               if (bridged) {
                 EXPECT_LT(log_rotation(Quat(q[0], q[1], q[2], q[3])).norm(), 5 * kRadPerDeg) << t;
               }
             }
           }
           if (t > 14.3 && t < 14.58) {
             ++beyond;
             EXPECT_FALSE(frame.has_head) << "too long";
           }
         });
    EXPECT_GE(within, 3U);
    EXPECT_GE(beyond, 15U);
  }
}

}  // namespace
}  // namespace mien::imu::pipeline_gaps_test
