#include <gtest/gtest.h>

#include "mien/shaping/merge.h"
#include "mien/shaping/shaper.h"
#include "tests/shaping/frames.h"

// What is heard among what is sensed, and regions that nobody senses any more.
namespace mien::shaping::merge_heard_test {
namespace {

using face::OutputFrame;
using face::Provenance;
using face::shape;

constexpr std::size_t kImu = 0;
const std::size_t kBrow = shape("browDown_L");
const std::size_t kSmile = shape("mouthSmile_L");
const std::size_t kJaw = shape("jawOpen");

/// Mouth and jaw as they sound while somebody speaks; else nothing.
OutputFrame speech(std::int64_t index, float weight, bool speaks = true) {
  OutputFrame frame = face::neutral_frame(frame_time(index));
  for (std::size_t k = 0; speaks && k < face::kShapeCount; ++k) {
    const bool heard = face::kShapeRegions[k] == face::ShapeRegion::mouth ||
                       face::kShapeRegions[k] == face::ShapeRegion::jaw;
    frame.weights[k] = heard ? weight : 0;
    frame.provenance[k] = heard ? Provenance::audio : Provenance::neutral;
  }
  return frame;
}

/// IMUs whose sensors explain so much of mouth and jaw, and speech.
OutputFrame sensed_and_heard(Merge& merge, int index, float mouth, float jaw, bool speaks = true,
                             std::size_t imus = 12) {
  OutputFrame imu = measured(index, 0.3F), sound = speech(index, 0.6F, speaks);
  tracker::Explained explained;
  explained.fill(0.9F);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    if (face::kShapeRegions[k] == face::ShapeRegion::mouth) explained[k] = k == kSmile ? mouth : 0;
    if (face::kShapeRegions[k] == face::ShapeRegion::jaw) explained[k] = k == kJaw ? jaw : 0;
  }
  const std::array<Merge::Source, 2> sources = {Merge::Source{&imu, imus, &explained},
                                                Merge::Source{&sound, 1}};
  OutputFrame out;
  merge.apply(sources, out);
  return out;
}

TEST(Merge, SoundAnswersForARegionThatNobodySenses) {
  Merge merge({"imu", "speech"});
  int taken = -1;
  for (int i = 0; i < 120; ++i) {
    const bool lost = i >= 60;  // The cheeks' sensors fell off, the chin's is there.
    const OutputFrame out = sensed_and_heard(merge, i, lost ? 0.1F : 0.8F, 0.8F);
    const bool heard = out.provenance[kSmile] == Provenance::audio;
    if (heard && taken < 0) taken = i;
    ASSERT_EQ(heard, taken >= 0);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      ASSERT_EQ(out.provenance[k] == Provenance::audio,
                heard && face::kShapeRegions[k] == face::ShapeRegion::mouth)
          << "all of the mouth, also what IMUs never explained, and nothing else: " << face::kShapeNames[k];
    if (i == 119) {
      EXPECT_EQ(out.weights[kSmile], 0.6F);
    }
  }
  EXPECT_EQ(taken, 66) << "a tenth of a second later";
}

TEST(Merge, SoundGivesWayToSensorsThatAreSureAgain) {
  Merge merge({"imu", "speech"});
  for (int i = 0; i < 30; ++i) sensed_and_heard(merge, i, 0.1F, 0.1F);
  EXPECT_EQ(sensed_and_heard(merge, 30, 0.4F, 0.4F).provenance[kJaw], Provenance::audio)
      << "more than unsure is not sure";
  EXPECT_EQ(sensed_and_heard(merge, 31, 0.4F, 0.6F).provenance[kJaw], Provenance::measured);
  EXPECT_EQ(sensed_and_heard(merge, 32, 0.4F, 0.6F).provenance[kSmile], Provenance::audio);
  for (int i = 33; i < 90; ++i)
    EXPECT_EQ(sensed_and_heard(merge, i, 0.4F, 0.4F).provenance[kJaw], Provenance::measured)
        << "and keeps it";
}

TEST(Merge, ShortGapsAndSilenceAreNotHeard) {
  Merge merge({"imu", "speech"});
  for (int i = 0; i < 200; ++i)
    ASSERT_NE(sensed_and_heard(merge, i, i % 10 < 5 ? 0.1F : 0.8F, 0.8F).provenance[kSmile],
              Provenance::audio);
  // Nobody speaks: as without a microphone.
  Merge silent({"imu", "speech"});
  for (int i = 0; i < 100; ++i) {
    const OutputFrame out = sensed_and_heard(silent, i, i < 50 ? 0.8F : 0.1F, 0.8F, false);
    EXPECT_NE(out.provenance[kSmile], Provenance::audio);
    if (i < 55) {
      EXPECT_EQ(out.weights[kSmile], 0.3F);
    }
  }
  EXPECT_EQ(silent.answers(kSmile), std::nullopt);
}

TEST(Merge, WhatAnotherProgramHasFromAudioIsMergedAsItsOther) {
  // By the order, for every region: it is no microphone of ours.
  Merge merge({"imu", "weights"});
  OutputFrame imu = measured(0, 0.3F), told = measured(0, 0.6F);
  told.provenance.fill(Provenance::audio);
  const std::array<Merge::Source, 2> sources = {Merge::Source{&imu, 12}, Merge::Source{&told, 1}};
  OutputFrame out;
  merge.apply(sources, out);
  EXPECT_EQ(out.provenance[kSmile], Provenance::audio);
  EXPECT_EQ(out.provenance[kBrow], Provenance::audio);
  EXPECT_EQ(out.weights[kJaw], 0.6F);
}

TEST(Merge, SoundIsHeardWhateverCountsAsSensed) {
  Merge merge({"imu", "speech"}, {.sure = 0, .unsure = 0});
  OutputFrame out;
  for (int i = 0; i < 60; ++i) out = sensed_and_heard(merge, i, 0.8F, 0.8F, true, i < 20 ? 12 : 0);
  EXPECT_EQ(out.provenance[kJaw], Provenance::audio);
}

TEST(Merge, SoundAnswersForMouthAndJawWhereAllSensorsAreLost) {
  Merge merge({"imu", "speech"});
  OutputFrame before = sensed_and_heard(merge, 0, 0.8F, 0.8F);
  double largest = 0;
  for (int i = 1; i < 400; ++i) {
    const bool lost = i >= 60 && i < 200;
    const OutputFrame out = sensed_and_heard(merge, i, 0.8F, 0.8F, true, lost ? 0 : 12);
    largest = std::max(largest, largest_step(out, before));
    before = out;
    if (i == 199) {
      EXPECT_EQ(out.provenance[kJaw], Provenance::audio);
      EXPECT_NEAR(out.weights[kJaw], 0.6F, 0.01);
      EXPECT_NE(out.provenance[kBrow], Provenance::audio) << "brows are held, then neutral";
    }
  }
  EXPECT_EQ(before.provenance[kJaw], Provenance::measured);
  EXPECT_LT(largest, 0.1 * 0.3 + 0.05) << "eased over both ways";
}

TEST(Merge, ARegionThatNobodySensesIsHeldAndFades) {
  Merge both({"imu", "speech"});
  float shown = 0;
  for (int i = 0; i < 30; ++i) shown = sensed_and_heard(both, i, 0.9F, 0.9F, false).weights[kJaw];
  EXPECT_FLOAT_EQ(shown, 0.3F);
  // The jaw's sensors are lost, and nobody speaks.
  OutputFrame out;
  for (int i = 30; i < 36; ++i) out = sensed_and_heard(both, i, 0.9F, 0.2F, false);
  EXPECT_EQ(both.answers(kJaw), kImu) << "not within a tenth of a second";
  for (int i = 36; i < 50; ++i) out = sensed_and_heard(both, i, 0.9F, 0.2F, false);
  EXPECT_EQ(both.answers(kJaw), std::nullopt);
  EXPECT_NEAR(out.weights[kJaw], 0.3F, 0.02) << "held";
  EXPECT_EQ(both.answers(kSmile), kImu) << "the mouth is still sensed";
  for (int i = 50; i < 300; ++i) out = sensed_and_heard(both, i, 0.9F, 0.2F, false);
  EXPECT_NEAR(out.weights[kJaw], 0, 1e-3);
  EXPECT_EQ(out.provenance[kJaw], Provenance::neutral);
  for (int i = 300; i < 308; ++i) out = sensed_and_heard(both, i, 0.9F, 0.9F, false);
  EXPECT_EQ(both.answers(kJaw), kImu);
  EXPECT_LT(out.weights[kJaw], 0.25F) << "eased in";
  for (int i = 308; i < 400; ++i) out = sensed_and_heard(both, i, 0.9F, 0.9F, false);
  EXPECT_NEAR(out.weights[kJaw], 0.3F, 1e-3);
}

TEST(Merge, SensorsThatNeverExplainedARegionGoOnAnswering) {
  Merge both({"imu", "speech"});
  for (int i = 0; i < 60; ++i)
    EXPECT_EQ(sensed_and_heard(both, i, 0.9F, 0.2F, false).weights[kJaw], 0.3F) << "it never fell";
}

TEST(Merge, WhatNobodyMeasuredIsNoGap) {
  Merge both({"weights", "speech"});
  for (int i = 0; i < 60; ++i) {
    OutputFrame weights = measured(i, 0.3F), sound = speech(i, 0.6F, false);
    weights.confidence.fill(0);
    const std::array<Merge::Source, 2> sources = {Merge::Source{&weights, 1}, Merge::Source{&sound, 1}};
    OutputFrame out;
    both.apply(sources, out);
    EXPECT_EQ(out.weights[kJaw], 0.3F);
  }
}

TEST(Merge, WithoutAudioNothingIsEverFromSound) {
  MergeSettings settings;
  settings.audio = false;
  Merge both({"imu", "speech"}, settings);
  for (int i = 0; i < 120; ++i) {
    const OutputFrame out = sensed_and_heard(both, i, 0.1F, 0.1F, true, i < 60 ? 12 : 0);
    EXPECT_EQ(std::ranges::count(out.provenance, Provenance::audio), 0);
  }
}

}  // namespace
}  // namespace mien::shaping::merge_heard_test
