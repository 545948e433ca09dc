#include "mien/shaping/merge.h"

#include <gtest/gtest.h>

#include <limits>

#include "mien/face/frame_hash.h"
#include "mien/shaping/shaper.h"
#include "tests/shaping/frames.h"

namespace mien::shaping::merge_test {
namespace {

using face::OutputFrame;
using face::Provenance;
using face::shape;

constexpr std::size_t kImu = 0;
constexpr std::size_t kEyewear = 1;
const std::size_t kBrow = shape("browDown_L");
const std::size_t kBlink = shape("eyeBlink_R");
const std::size_t kNose = shape("noseSneer_L");
const std::size_t kSmile = shape("mouthSmile_L");
const std::size_t kJaw = shape("jawOpen");

/// Frames of Merge::kWarmUp at 60 Hz.
constexpr int kWarmUpFrames = 9;

/// Glasses: sure of the shapes, and nothing of the head.
OutputFrame glasses(std::int64_t index, float weight) {
  OutputFrame frame = measured(index, weight);
  frame.head_confidence = 0;
  frame.head_provenance = Provenance::neutral;
  return frame;
}

/// A tracker that has no calibration yet.
OutputFrame uncalibrated(std::int64_t index) {
  return face::neutral_frame(frame_time(index));
}

/// The merged frame of IMUs and glasses, and how many sensors stand behind it.
struct Merged {
  OutputFrame frame;
  std::size_t behind = 0;
};
Merged merge(Merge& merge, OutputFrame imu, std::size_t imus, OutputFrame eyewear, std::size_t lights) {
  const std::array<Merge::Source, 2> sources = {Merge::Source{&imu, imus}, Merge::Source{&eyewear, lights}};
  Merged out;
  out.behind = merge.apply(sources, out.frame);
  return out;
}

TEST(Merge, ALoneTrackerPassesToTheBit) {
  Merge alone({"imu"});
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    OutputFrame in = moving(i, random);
    in.eyes_rad[0] = {0.1F, -0.0F};
    const OutputFrame as_it_was = in;
    OutputFrame out;
    const std::size_t there =
        i > 290 ? 0 : static_cast<std::size_t>(1 + i % 3);  // To be lost is fallback's affair.
    const std::array<Merge::Source, 1> sources = {Merge::Source{&in, there}};
    ASSERT_EQ(alone.apply(sources, out), there);
    ASSERT_TRUE(same_bits(out, as_it_was));
  }
}

TEST(Merge, ATrackerWarmsUpOnceItsSensorsAreBack) {
  Merge alone({"imu"});
  const auto count_at = [&](int i, std::size_t there) {
    OutputFrame in = measured(i, 0.5F), out;
    const std::array<Merge::Source, 1> sources = {Merge::Source{&in, there}};
    return alone.apply(sources, out);
  };
  EXPECT_EQ(count_at(0, 11), 11U) << "at a session's beginning nobody waits";
  EXPECT_EQ(count_at(1, 3), 3U) << "nor for some of the sensors";
  EXPECT_EQ(count_at(2, 0), 0U);
  for (int i = 3; i < 3 + kWarmUpFrames; ++i) EXPECT_EQ(count_at(i, 11), 0U) << i;
  EXPECT_EQ(count_at(3 + kWarmUpFrames, 11), 11U);
  EXPECT_EQ(count_at(4 + kWarmUpFrames, 0), 0U) << "and again";
  EXPECT_EQ(count_at(5 + kWarmUpFrames, 11), 0U);
}

TEST(Merge, APartThatASourceNewlyTellsDoesNotJump) {
  Merge both({"imu", "weights"});
  OutputFrame before;
  for (int i = 0; i < 60; ++i) {
    OutputFrame imu = measured(i, 0.5F), weights = measured(i, 0.5F);
    imu.head = exp_rotation({0, 0.1, 0});
    weights.head = exp_rotation({0, 0.9, 0});
    if (i < 20) {  // Its head is not told yet, only its face.
      weights.head = Quat::Identity();
      weights.head_provenance = Provenance::neutral;
      weights.head_confidence = 0;
    }
    const std::array<Merge::Source, 2> sources = {Merge::Source{&imu, 11}, Merge::Source{&weights, 1}};
    OutputFrame out;
    both.apply(sources, out);
    if (i > 0) {
      ASSERT_LE(angle_between(out.head, before.head), 0.1 * 0.8) << i;
    }
    before = out;
  }
  EXPECT_NEAR(angle_between(before.head, exp_rotation({0, 0.9, 0})), 0, 0.01) << "it leads the head";
}

TEST(Merge, LeftOutTheFirstSourcePassesAsItIs) {
  Merge merging({"imu", "eyewear"});
  merging.set({}, {}, false);
  OutputFrame imu = uncalibrated(0);
  imu.weights[kSmile] = 1.5F;
  const Merged off = merge(merging, imu, 12, glasses(0, 0.25F), 16);
  EXPECT_TRUE(same_bits(off.frame, imu));
  EXPECT_EQ(off.behind, 12U);
  merging.set({}, {});
  EXPECT_EQ(merge(merging, uncalibrated(1), 12, glasses(1, 0.25F), 16).frame.weights[kSmile], 0.25F);
}

TEST(Merge, EachRegionIsAnsweredByTheFirstOfItsOrder) {
  Merge both({"imu", "eyewear"});
  OutputFrame imu = measured(0, 0.2F);
  imu.tongue_out = 0.9F;
  imu.head = exp_rotation({0, 0.4, 0});
  const Merged out = merge(both, imu, 12, glasses(0, 0.8F), 20);
  EXPECT_EQ(out.behind, 32u);
  EXPECT_EQ(out.frame.time, frame_time(0));
  for (const std::size_t eyewear : {kBrow, kBlink}) EXPECT_EQ(out.frame.weights[eyewear], 0.8F);
  for (const std::size_t by_imu : {kNose, kSmile, kJaw}) EXPECT_EQ(out.frame.weights[by_imu], 0.2F);
  EXPECT_EQ(out.frame.tongue_out, 0.9F);
  EXPECT_EQ(out.frame.head_provenance, Provenance::measured);
  EXPECT_EQ(angle_between(out.frame.head, imu.head), 0);
  EXPECT_EQ(both.answers(kBrow), kEyewear);
  EXPECT_EQ(both.answers(kJaw), kImu);
  EXPECT_EQ(both.answers(kHeadPart), kImu);
  EXPECT_EQ(both.answers(kEyesPart), std::nullopt) << "neither knows where the eyes look";
}

TEST(Merge, ConfidenceAndProvenanceAreThoseOfWhoAnswers) {
  Merge both({"imu", "eyewear"});
  OutputFrame imu = measured(0, 0.2F), eyewear = glasses(0, 0.8F);
  imu.confidence.fill(0.6F);
  imu.provenance.fill(Provenance::predicted);
  const Merged out = merge(both, imu, 12, eyewear, 20);
  EXPECT_EQ(out.frame.confidence[kJaw], 0.6F);
  EXPECT_EQ(out.frame.provenance[kJaw], Provenance::predicted);
  EXPECT_EQ(out.frame.confidence[kBrow], 0.9F);
  EXPECT_EQ(out.frame.provenance[kBrow], Provenance::measured);
}

TEST(Merge, TheOrderIsASettingAndUnnamedTrackersComeLast) {
  MergeSettings settings;
  settings.order[static_cast<std::size_t>(MergePlace::mouth)] = {"eyewear"};
  settings.order[static_cast<std::size_t>(MergePlace::brows)] = {"nobody", "speech"};
  Merge both({"imu", "eyewear"}, settings);
  const Merged out = merge(both, measured(0, 0.2F), 12, glasses(0, 0.8F), 20);
  EXPECT_EQ(out.frame.weights[kSmile], 0.8F);
  EXPECT_EQ(out.frame.weights[kBrow], 0.2F) << "the session's own order";
}

TEST(Merge, WhoIsNotSureGivesWayAndTheMostConfidentFillsIn) {
  Merge both({"imu", "eyewear"});
  OutputFrame imu = measured(0, 0.2F), eyewear = glasses(0, 0.8F);
  imu.confidence.fill(0.3F);
  EXPECT_EQ(merge(both, imu, 3, eyewear, 20).frame.weights[kJaw], 0.8F);
  both.reset();
  eyewear.confidence.fill(0.2F);
  EXPECT_EQ(merge(both, imu, 3, eyewear, 4).frame.weights[kBrow], 0.2F) << "nobody is sure: the surer";
  // Who answers now stays until another is surer by sure - unsure.
  imu.time = eyewear.time = frame_time(1);
  imu.confidence.fill(0.2F);
  eyewear.confidence.fill(0.3F);
  merge(both, imu, 3, eyewear, 4);
  EXPECT_EQ(both.answers(kBrow), kImu);
  imu.time = eyewear.time = frame_time(2);
  eyewear.confidence.fill(0.4F);
  merge(both, imu, 3, eyewear, 4);
  EXPECT_EQ(both.answers(kBrow), kEyewear);
}

TEST(Merge, WhoExplainsMoreAnswersWhateverTheWeightsSay) {
  // The probability of a small error falls with the weight, whoever answers: nothing follows from it.
  Merge both({"imu", "eyewear"});
  tracker::Explained by_imu{}, by_eyewear{};
  by_imu.fill(0.3F);
  by_imu[kSmile] = 0.8F;
  by_eyewear.fill(0.1F);
  by_eyewear[kJaw] = 0.5F;
  OutputFrame out;
  for (int i = 0; i < 60; ++i) {
    OutputFrame imu = measured(i, 0.2F), eyewear = glasses(i, 0.8F);
    imu.provenance.fill(Provenance::predicted);
    imu.confidence.fill(i < 30 ? 0.9F : 0.1F);
    eyewear.confidence.fill(i % 10 < 5 ? 0.9F : 0.1F);
    const std::array<Merge::Source, 2> sources = {
        Merge::Source{.frame = &imu, .sensors_present = 12, .explained = &by_imu},
        Merge::Source{.frame = &eyewear, .sensors_present = 20, .explained = &by_eyewear}};
    both.apply(sources, out);
    ASSERT_EQ(both.answers(kSmile), kImu) << i;
    ASSERT_EQ(both.answers(kBrow), kImu) << "the glasses are asked first, and neither is sure: " << i;
    ASSERT_EQ(both.answers(kJaw), kEyewear)
        << "the IMUs are asked first, and only the glasses are sure: " << i;
    ASSERT_EQ(both.answers(kHeadPart), kImu) << i;
  }
}

TEST(Merge, ARegionsConfidenceStandsForItsShapesWhereNobodyMeasuredMore) {
  Merge both({"imu", "eyewear"});
  tracker::Explained by_imu{};
  by_imu.fill(0.6F);
  int i = 0;
  const auto answered = [&](float imu_region, float glasses_region, const tracker::Explained* explained) {
    OutputFrame imu = measured(i, 0.2F), eyewear = glasses(i, 0.8F), out;
    ++i;
    imu.confidence.fill(0.1F);
    eyewear.confidence.fill(0.3F);
    imu.region_confidence.fill(imu_region);
    eyewear.region_confidence.fill(glasses_region);
    const std::array<Merge::Source, 2> sources = {
        Merge::Source{.frame = &imu, .sensors_present = 12, .explained = explained},
        Merge::Source{.frame = &eyewear, .sensors_present = 20}};
    both.reset();
    both.apply(sources, out);
    return both.answers(kJaw);
  };
  EXPECT_EQ(answered(0, 0, nullptr), kEyewear) << "unknown: the shapes' own, and neither is sure";
  EXPECT_EQ(answered(0.8F, 0, nullptr), kImu);
  EXPECT_EQ(answered(0.45F, 0.2F, nullptr), kImu) << "the surer";
  EXPECT_EQ(answered(0.01F, 0, &by_imu), kImu) << "what is explained goes before";
}

TEST(Merge, ARegionsConfidenceIsThatOfWhoAnswersMostOfIt) {
  Merge both({"imu", "eyewear"});
  tracker::Explained by_imu{}, by_eyewear{};
  by_imu.fill(0.9F);
  const auto brows = static_cast<std::size_t>(face::ShapeRegion::brows);
  OutputFrame out;
  const auto apply = [&](int i, std::size_t imus, std::size_t lights) {
    OutputFrame imu = measured(i, 0.2F), eyewear = glasses(i, 0.8F);
    imu.region_confidence.fill(0.8F);
    eyewear.region_confidence.fill(0.6F);
    const std::array<Merge::Source, 2> sources = {
        Merge::Source{.frame = &imu, .sensors_present = imus, .explained = &by_imu},
        Merge::Source{.frame = &eyewear, .sensors_present = lights, .explained = &by_eyewear}};
    both.apply(sources, out);
    return out.region_confidence[brows];
  };
  by_eyewear[kBrow] = 0.9F;  // One of six, for which the glasses are asked first.
  EXPECT_EQ(apply(0, 12, 20), 0.8F);
  EXPECT_EQ(both.answers(kBrow), kEyewear);
  by_eyewear.fill(0.9F);
  EXPECT_EQ(apply(1, 12, 20), 0.6F);
  EXPECT_EQ(apply(2, 12, 0), 0.8F);
  const float half_gone = (apply(3, 0, 0), apply(27, 0, 0));
  EXPECT_NEAR(half_gone, 0.8F * (1 - 25.0F / 48), 0.01F) << "hold of 0.3 s and 0.5 s to neutral";
  EXPECT_EQ(apply(80, 0, 0), 0);
}

TEST(Merge, ChangesHandsOnlyForAClearlyLargerShare) {
  Merge both({"imu", "eyewear"});
  tracker::Explained by_imu{}, by_eyewear{};
  by_imu.fill(0.3F);
  int i = 0;
  const auto answered = [&](float share) {
    OutputFrame imu = measured(i, 0.2F), eyewear = glasses(i, 0.8F), out;
    ++i;
    by_eyewear.fill(share);
    const std::array<Merge::Source, 2> sources = {
        Merge::Source{.frame = &imu, .sensors_present = 12, .explained = &by_imu},
        Merge::Source{.frame = &eyewear, .sensors_present = 20, .explained = &by_eyewear}};
    both.apply(sources, out);
    return both.answers(kBrow);
  };
  EXPECT_EQ(answered(0.2F), kImu);
  EXPECT_EQ(answered(0.44F), kImu) << "by less than the hysteresis of 0.15";
  EXPECT_EQ(answered(0.46F), kEyewear);
  EXPECT_EQ(answered(0.2F), kEyewear);
  EXPECT_EQ(answered(0.14F), kImu);
  EXPECT_EQ(answered(0.49F), kEyewear) << "by more than it";
}

TEST(Merge, WhoExplainsNothingIsNotKeptBecauseItCameFirst) {
  Merge both({"imu", "eyewear"});
  tracker::Explained by_imu{}, by_eyewear{};
  by_imu[kBrow] = 0.1F;
  for (int i = 0; i < 60; ++i) {
    OutputFrame imu = measured(i, 0.2F), eyewear = glasses(i, 0.8F), out;
    const bool calibrated = i >= 30;
    if (!calibrated) imu = uncalibrated(i);
    const std::array<Merge::Source, 2> sources = {
        Merge::Source{.frame = &imu, .sensors_present = 12, .explained = &by_imu},
        Merge::Source{.frame = &eyewear, .sensors_present = 20, .explained = &by_eyewear}};
    both.apply(sources, out);
    ASSERT_EQ(both.answers(kBrow), calibrated ? kImu : kEyewear) << i;
    ASSERT_EQ(both.answers(kNose), calibrated ? kImu : kEyewear) << "neither knows it: by the order, " << i;
    ASSERT_EQ(both.answers(kBlink), kEyewear) << "likewise: " << i;
  }
}

TEST(Merge, AConfidenceAboutTheThresholdDoesNotFlap) {
  Merge both({"imu", "eyewear"});
  Random random(4);
  int hand_overs = 0;
  std::optional<std::size_t> before;
  for (int i = 0; i < 3000; ++i) {
    OutputFrame eyewear = glasses(i, 0.8F);
    eyewear.confidence.fill(static_cast<float>(0.5 + random.uniform(-0.12, 0.12)));
    merge(both, measured(i, 0.2F), 12, eyewear, 10);
    if (before && both.answers(kBrow) != before) ++hand_overs;
    before = both.answers(kBrow);
  }
  EXPECT_LE(hand_overs, 1) << "once it is sure it stays";
  EXPECT_EQ(before, kEyewear);
}

TEST(Merge, WhoLosesSightOfARegionGivesItUpAsAWholeUntilItIsSureAgain) {
  // A headset whose lower face a hand hides, beside IMUs that are sure of the smile and not of the jaw.
  Merge both({"imu", "camera"});
  constexpr std::size_t kCamera = 1;
  tracker::Explained by_imu{}, by_camera{};
  by_imu[kSmile] = 0.6F;
  by_imu[shape("mouthPucker")] = 0.1F;
  by_imu[kJaw] = 0.55F;
  by_camera.fill(0.8F);
  int i = 0;
  std::size_t there = 12;
  const auto judged = [&](float lower) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (face::kShapeRegions[k] == face::ShapeRegion::mouth ||
          face::kShapeRegions[k] == face::ShapeRegion::jaw)
        by_camera[k] = lower;
    OutputFrame imu = measured(i, 0.2F), camera = glasses(i, 0.8F), out;
    ++i;
    const std::array<Merge::Source, 2> sources = {
        Merge::Source{.frame = &imu, .sensors_present = there, .explained = &by_imu},
        Merge::Source{.frame = &camera, .sensors_present = 4, .explained = &by_camera}};
    both.apply(sources, out);
    return std::array{both.answers(kSmile), both.answers(shape("mouthPucker")), both.answers(kJaw),
                      both.answers(shape("jawLeft"))};
  };
  using Who = std::array<std::optional<std::size_t>, 4>;
  const Who sees{kCamera, kCamera, kCamera, kCamera}, hidden{kImu, kImu, kImu, kImu};
  EXPECT_EQ(judged(0.8F), sees);
  EXPECT_EQ(judged(0.4F), sees) << "down to `unsure`";
  EXPECT_EQ(judged(0.3F), hidden) << "what nobody is sure of too: it is a picture of a hand";
  EXPECT_EQ(both.answers(kBrow), kCamera);
  EXPECT_EQ(judged(0.45F), hidden) << "not before it is sure";
  EXPECT_EQ(judged(0.6F), sees);
  EXPECT_EQ(judged(0.3F), hidden);
  there = 0;
  for (int f = 0; f < 3; ++f) EXPECT_EQ(judged(0.3F), sees) << "nobody else sees it";
}

TEST(Merge, ATrackerThatDropsOutIsReplacedSoftlyAndComesBackSoftly) {
  Merge both({"imu", "eyewear"});
  Shaper shaper;
  OutputFrame before;
  double largest = 0, largest_shaped = 0, largest_turn = 0;
  OutputFrame shaped_before;
  for (int i = 0; i < 400; ++i) {
    // From one extreme to the other: the IMUs' mouth is open, the glasses' closed.
    const bool lost = i >= 100 && i < 250, warms_up = i >= 250 && i < 250 + kWarmUpFrames;
    OutputFrame imu = measured(i, 1);
    imu.head = exp_rotation({0.2, 0.5, 0});
    if (lost) {
      imu.provenance.fill(Provenance::predicted);  // What a tracker guesses without any sensor.
      imu.confidence.fill(0);
      imu.weights.values.fill(0.4F);
      imu.head = Quat::Identity();
    }
    const Merged out = merge(both, imu, lost ? 0 : 12, glasses(i, 0), 20);
    OutputFrame shaped = out.frame;
    shaper.apply(shaped, out.behind);
    if (i > 0) {
      largest = std::max(largest, largest_step(out.frame, before));
      largest_shaped = std::max(largest_shaped, largest_step(shaped, shaped_before));
      largest_turn = std::max(largest_turn, angle_between(shaped.head, shaped_before.head));
    }
    before = out.frame;
    shaped_before = shaped;
    ASSERT_EQ(out.behind, lost || warms_up ? 20u : 32u) << i;
    ASSERT_EQ(out.frame.provenance[kSmile], Provenance::measured);
    if (i == 99) {
      EXPECT_EQ(out.frame.weights[kSmile], 1);
    }
    if (i >= 100 && i < 130) {
      // The closed form, from the last frame with IMUs on.
      const double way = kConstantsTo5Percent / 0.3 * to_seconds(frame_time(i) - frame_time(99));
      ASSERT_NEAR(out.frame.weights[kSmile], offset_left(way), 1e-6) << i;
    }
    if (i == 99 + 15) {
      EXPECT_NEAR(shaped.weights[kSmile], out.frame.weights[kSmile], 0.02) << "eased once, not twice";
      EXPECT_EQ(out.frame.head_provenance, Provenance::held) << "the glasses know nothing of it";
      EXPECT_LT(angle_between(shaped.head, exp_rotation({0.2, 0.5, 0})), 1e-6);
    }
    if (i == 200) {
      EXPECT_EQ(out.frame.weights[kSmile], 0);
      EXPECT_EQ(out.frame.head_provenance, Provenance::neutral);
      EXPECT_LT(angle_between(out.frame.head, twist_about(exp_rotation({0.2, 0.5, 0}), Vec3::UnitY())), 1e-9);
    }
  }
  EXPECT_EQ(before.weights[kSmile], 1);
  EXPECT_LE(largest, 0.0975);
  EXPECT_LE(largest_shaped, 0.1);
  EXPECT_LE(largest_turn, 0.06);
}

/// Three trackers that come and go, are sure and are not, and now and then answer with what is no number.
/// Returns the hash of what was merged.
std::string hash_of_trouble() {
  Merge three({"imu", "eyewear", "speech"});
  Random random(6);
  std::array<bool, 3> there = {true, true, true};
  std::array<float, 3> sure = {0.9F, 0.9F, 0.6F};
  OutputFrame before, shaped_before;
  Shaper shaper;
  face::FrameHash hash;
  for (int i = 0; i < 6000; ++i) {
    std::array<OutputFrame, 3> frames;
    std::array<Merge::Source, 3> sources;
    for (std::size_t s = 0; s < 3; ++s) {
      if (random.uniform(0, 1) < 0.02) there[s] = !there[s];
      if (random.uniform(0, 1) < 0.05) sure[s] = static_cast<float>(random.uniform(0, 1));
      frames[s] = moving(i + 200 * static_cast<std::int64_t>(s), random);
      frames[s].time = frame_time(i);
      frames[s].confidence.fill(there[s] ? sure[s] : 0);
      if (s == 2) frames[s].provenance.fill(Provenance::audio);
      if (random.below(50) == 0) frames[s].weights[random.below(face::kShapeCount)] = std::nanf("");
      if (random.below(50) == 0) frames[s].confidence[random.below(face::kShapeCount)] = std::nanf("");
      if (random.below(200) == 0) frames[s].head = Quat(0, 0, std::numeric_limits<double>::infinity(), 0);
      sources[s] = {&frames[s], there[s] ? 10u : 0u};
    }
    OutputFrame out;
    const std::size_t behind = three.apply(sources, out);
    EXPECT_LE(behind, 10u * static_cast<std::size_t>(std::ranges::count(there, true))) << "some warm up";
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      EXPECT_GE(out.weights[k], 0) << i;
      EXPECT_LE(out.weights[k], 1) << i;
      EXPECT_GE(out.confidence[k], 0) << i;
      EXPECT_LE(out.confidence[k], 1) << i;
      if (const auto who = three.answers(k)) {
        EXPECT_TRUE(there[*who]);
        EXPECT_EQ(out.confidence[k], frames[*who].confidence[k]);
        EXPECT_EQ(out.provenance[k], frames[*who].provenance[k]);
      }
    }
    EXPECT_NEAR(out.head.norm(), 1, 1e-9);
    EXPECT_TRUE(std::isfinite(out.tongue_out));
    OutputFrame shaped = out;
    shaper.apply(shaped, behind);
    if (i > 0) {
      // The waves themselves step by up to 0.045 and their noise by 0.04.
      EXPECT_LE(largest_step(out, before), 0.25) << i;
      EXPECT_LE(largest_step(shaped, shaped_before), kStepAtMost) << i;
    }
    before = out;
    shaped_before = shaped;
    hash.add(out);
  }
  return hash.hex();
}

TEST(Merge, WhateverHappensIsSoundAndWithinTheStatedStepAndTheSameEachTime) {
  EXPECT_EQ(hash_of_trouble(), hash_of_trouble());
}

TEST(Merge, AnUncalibratedTrackerIsNotAskedAndDoesNotCount) {
  Merge both({"imu", "eyewear"});
  EXPECT_EQ(merge(both, uncalibrated(0), 11, uncalibrated(0), 20).behind, 31u) << "nothing is lost yet";
  Merged out = merge(both, uncalibrated(1), 11, glasses(1, 0.8F), 20);
  EXPECT_EQ(out.behind, 20u);
  EXPECT_EQ(out.frame.provenance[kJaw], Provenance::measured);
  EXPECT_EQ(out.frame.head_provenance, Provenance::neutral);
  out = merge(both, uncalibrated(2), 11, glasses(2, 0.8F), 0);
  EXPECT_EQ(out.behind, 0u) << "the one that knew something is gone";
  EXPECT_EQ(out.frame.provenance[kJaw], Provenance::held);
}

TEST(Merge, AllLostIsFallbacksAffairAndComesBackWithoutAJump) {
  Merge both({"imu", "eyewear"});
  Shaper shaper;
  OutputFrame before;
  for (int i = 0; i < 400; ++i) {
    const bool lost = i >= 60 && i < 240;
    const Merged out =
        merge(both, measured(i, 0.9F), lost ? 0 : 12, glasses(i, 0.7F), lost && i < 280 ? 0 : 20);
    ASSERT_EQ(out.behind == 0, lost || (i >= 240 && i < 240 + kWarmUpFrames)) << i;
    OutputFrame shaped = out.frame;
    shaper.apply(shaped, out.behind);
    if (i > 0) {
      ASSERT_LE(largest_step(shaped, before), 0.1) << i;
    }
    if (i == 239) {
      EXPECT_EQ(shaped.weights[kJaw], 0);
    }
    before = shaped;
  }
  EXPECT_EQ(before.weights[kJaw], 0.9F);
  EXPECT_EQ(before.weights[kBrow], 0.7F);
}

TEST(Merge, BeginsAnewWhenTimeRunsBack) {
  Merge both({"imu", "eyewear"});
  merge(both, measured(10, 1), 12, glasses(10, 1), 20);
  const Merged out = merge(both, measured(3, 0.2F), 12, glasses(3, 0.2F), 0);
  EXPECT_EQ(out.frame.weights[kBrow], 0.2F) << "no way to go from what was shown then";
  EXPECT_EQ(both.answers(kBrow), kImu);
}

TEST(Merge, BringsItsFiguresIntoRange) {
  MergeSettings settings;
  settings.sure = std::nanf("");
  settings.unsure = 7;
  Merge both({"imu", "eyewear"}, settings, {.hold_s = -1, .neutral_s = std::nan(""), .return_s = 0});
  for (int i = 0; i < 60; ++i) {
    const Merged out =
        merge(both, measured(i, 0.2F), i % 7 == 0 ? 0 : 3, glasses(i, 0.8F), i % 5 == 0 ? 0 : 3);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) ASSERT_TRUE(std::isfinite(out.frame.weights[k]));
  }
}

}  // namespace
}  // namespace mien::shaping::merge_test
