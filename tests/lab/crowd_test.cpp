#include "lab/crowd.h"

#include <gtest/gtest.h>

#include "mien/model/network_correction.h"
#include "mien/tracker/causal_tracker.h"
#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::lab::crowd_test {
namespace {

using tracker::CausalTracker;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

bool same(const face::OutputFrame& a, const face::OutputFrame& b) {
  return a.time == b.time && a.weights == b.weights && a.confidence == b.confidence &&
         a.provenance == b.provenance;
}

/// Each performer is elsewhere in the same motion.
model::FeatureFrame frame_of(std::size_t performer, std::size_t frame) {
  static const auto features = tracker::test::turning(200);
  return features[performer + frame];
}

TEST(Crowd, EverybodyGetsWhatATrackerOfTheirOwnGives) {
  constexpr std::size_t kPerformers = Crowd::kTogether + 5, kFrames = 9;
  auto file = tracker::test::tiny_causal_model(kSensors);
  // A wearer's, too.
  const model::Architecture& a = file.architecture;
  file.correction = {.network = model::correction_key(file.network),
                     .weights = std::vector(a.outputs * a.d_model, 0.01F),
                     .bias = std::vector(a.outputs, 0.05F)};
  for (const model::Precision precision :
       {model::Precision::fp32, model::Precision::bf16, model::Precision::int8}) {
    Crowd crowd = Crowd::create(file, kSensors, kPerformers, precision).value();
    EXPECT_EQ(crowd.performers(), kPerformers);
    std::vector<CausalTracker> trackers;
    for (std::size_t p = 0; p < kPerformers; ++p)
      trackers.push_back(CausalTracker::create(file, kSensors, precision).value());
    for (std::size_t f = 0; f < kFrames; ++f) {
      if (f == 5) {
        crowd.reset(4);
        trackers[4].reset();
      }
      std::vector<std::size_t> due;
      std::vector<model::FeatureFrame> features;
      // Performers come in any order, and not everybody each time.
      for (std::size_t p = kPerformers; p-- > f;) {
        due.push_back(p);
        features.push_back(frame_of(p, f));
        if (p == 7) features.back().sensors[0].has_rotation = false;
      }
      std::vector<face::OutputFrame> out(due.size());
      crowd.step(due, features, out);
      for (std::size_t i = 0; i < due.size(); ++i) {
        face::OutputFrame alone;
        trackers[due[i]].step(features[i], alone);
        ASSERT_TRUE(same(out[i], alone)) << "frame " << f << ", performer " << due[i];
      }
    }
  }
}

TEST(Crowd, RefusesWhatATrackerRefuses) {
  EXPECT_FALSE(Crowd::create(tracker::test::tiny_model(kSensors), kSensors, 3));
  EXPECT_FALSE(Crowd::create(tracker::test::tiny_causal_model(kSensors), {"nobody"}, 3));
}

}  // namespace
}  // namespace mien::lab::crowd_test
