// Allocations are counted, by taking the place of operator new.
#include "mien/headset/headset_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "mien/headset/wearer_calibration.h"
#include "tests/allocation_count.h"
#include "tests/headset/worn_headset.h"

namespace mien::headset::headset_tracker_test {
namespace {

using namespace test;
using face::Provenance;
using tracker::Step;
using Phase = tracker::CalibrationState::Phase;

const std::size_t kBlinkR = face::shape("eyeBlink_R"), kLookL = face::shape("eyeLookIn_L");

TEST(HeadsetTracker, AnswersWhatItsNetworkDoesWithoutACalibrationToo) {
  Worn worn(HeadsetModel::create(constant_file(telling_answer())).value());
  worn.run(0.2);
  EXPECT_EQ(worn.result.sensors_present, 4U);
  EXPECT_NEAR(worn.frame.weights[kJaw], 0.5, 1e-5);
  EXPECT_NEAR(worn.frame.tongue_out, 0.2, 1e-5);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::measured);
  EXPECT_GE(worn.frame.confidence[kJaw], 0.5F);
  EXPECT_EQ(worn.frame.region_confidence[0], 0) << "nobody has measured it";
  EXPECT_EQ(worn.frame.eyes_provenance, Provenance::measured);
  EXPECT_NEAR(worn.frame.eyes_rad[0].x(), 0.2, 1e-5);
  EXPECT_NEAR(worn.frame.eyes_rad[1].y(), -0.1, 1e-5);
  EXPECT_GT(worn.frame.eyes_confidence, 0.5F);
  EXPECT_EQ(worn.frame.provenance[kLookL], Provenance::predicted) << "the lids are the eyes' to turn";
  EXPECT_EQ(worn.frame.head_provenance, Provenance::neutral);
  EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::done) << "nobody waits for one";
  EXPECT_TRUE(worn.tracker->calibration().empty());
}

/// A model that answers and judges the same whatever it reads; half of the jaw is what its memory would
/// add.
std::shared_ptr<const HeadsetModel> constant_memory(const Answer& answer, float logit) {
  Answer half = answer;
  half.weights[kJaw] = 0.5F * answer.weights[kJaw];
  ViewsFile file = constant_file(half);
  file.memory = small_memory();
  file.memory->judgements.fill({.offset = 0, .slope = 1});
  auto& network = file.memory->network;
  std::ranges::fill(network[network.size() - 2].values, 0.0F);
  std::vector<float>& bias = network.back().values;
  std::ranges::fill(bias, logit);
  std::array<float, kAnswerOutputs> whole{}, part{};
  encode_answer(answer, whole);
  encode_answer(half, part);
  std::ranges::transform(whole, part, bias.begin(), std::minus());
  return HeadsetModel::create(file).value();
}

TEST(HeadsetTracker, AMemoryJudgesItsAnswers) {
  Worn sure(constant_memory(telling_answer(), 2)), unsure(constant_memory(telling_answer(), -2));
  sure.run(0.2);
  unsure.run(0.2);
  EXPECT_NEAR(sure.frame.weights[kJaw], 0.25 + 0.1192 * 0.25, 1e-3) << "as much as it doubts";
  EXPECT_NEAR(unsure.frame.weights[kJaw], 0.25 + 0.8808 * 0.25, 1e-3);
  for (const float confidence : sure.frame.region_confidence) EXPECT_NEAR(confidence, 0.8808, 1e-3);
  for (const float confidence : unsure.frame.region_confidence) EXPECT_NEAR(confidence, 0.1192, 1e-3);
  EXPECT_NEAR(sure.frame.confidence[kJaw], 0.8808, 1e-3);
  EXPECT_NEAR(unsure.frame.confidence[kJaw], 0.1192, 1e-3);
  EXPECT_NEAR(sure.frame.eyes_confidence, 0.8808, 1e-3);
  sure.sends[0] = false;
  sure.run(0.3);
  EXPECT_LT(sure.frame.confidence[kBlinkL], 0.3F) << "its camera is away";
  EXPECT_NEAR(sure.frame.confidence[kBlinkR], 0.8808, 1e-3);
}

/// How far mouth and jaw move in a second, and brows and eyes, where every region is judged alike and the
/// memory adds nothing.
struct Moved {
  float lower = 0, upper = 0;
};
Moved moved_when_judged(float logit) {
  ViewsFile file = small_file_with_memory();
  file.memory->judgements.fill({.offset = 0, .slope = 1});
  auto& network = file.memory->network;
  std::ranges::fill(network[network.size() - 2].values, 0.0F);
  std::vector<float>& bias = network.back().values;
  std::ranges::fill(bias, 0.0F);
  std::fill(bias.begin() + kAnswerOutputs, bias.end(), logit);
  Worn worn(HeadsetModel::create(file).value());
  worn.run(0.2);
  face::BlendshapeWeights least = worn.frame.weights, most = least;
  for (int n = 0; n < 60; ++n) {
    worn.step();
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      least[k] = std::min(least[k], worn.frame.weights[k]);
      most[k] = std::max(most[k], worn.frame.weights[k]);
    }
  }
  Moved moved;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const face::ShapeRegion region = face::kShapeRegions[k];
    const bool upper = region == face::ShapeRegion::brows || region == face::ShapeRegion::eyes;
    float& most_of = upper ? moved.upper : moved.lower;
    most_of = std::max(most_of, most[k] - least[k]);
  }
  return moved;
}

TEST(HeadsetTracker, WhatItDoubtsMovesTheLowerFaceLittle) {
  const Moved sure = moved_when_judged(6), doubted = moved_when_judged(-6);
  EXPECT_GT(sure.lower, 0.01F);
  EXPECT_LT(doubted.lower, 0.5F * sure.lower);
  EXPECT_GT(doubted.upper, 0.5F * sure.upper) << "lids are quick";
}

TEST(HeadsetTracker, SaysThatEyesAreShownMirrored) {
  const auto scored = [](float log_odds, std::optional<std::size_t> away) {
    ViewsFile file = small_file_with_memory();
    file.memory->mirrored_eye = {.weight = std::vector<float>(8, 0.0F), .bias = log_odds};
    Worn worn(HeadsetModel::create(file).value());
    if (away) worn.sends[*away] = false;
    worn.run(0.2);
    worn.tracker->guide(Step::neutral, worn.now(), worn.now() + std::chrono::seconds(3));
    worn.run(3.1);
    EXPECT_EQ(worn.events.size(), 1U);
    EXPECT_TRUE(worn.tracker->calibration_state().hint.empty()) << "nothing has failed";
    std::vector<sensor::Score> scores = worn.tracker->scores();
    std::erase_if(scores, [](const sensor::Score& score) { return !score.name.starts_with("unmirrored "); });
    return scores;
  };
  for (const sensor::Score& score : scored(2.5F, {})) {
    EXPECT_TRUE(score.pass);
    EXPECT_NEAR(score.value, 0.0759, 1e-3);
  }
  const auto both = scored(3.5F, {}), left = scored(3.5F, 1), right = scored(3.5F, 0);
  ASSERT_EQ(both.size(), 2U);
  for (const sensor::Score& score : both) {
    EXPECT_FALSE(score.pass);
    EXPECT_NE(score.sentence.find("probably swapped"), std::string::npos) << score.sentence;
  }
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].name, "unmirrored eye_L");
  EXPECT_NE(left[0].sentence.find("change the camera's mirror"), std::string::npos);
  ASSERT_EQ(right.size(), 1U);
  EXPECT_EQ(right[0].name, "unmirrored eye_R");
}

TEST(HeadsetTracker, AMemoryForgetsWhatWasBeforeALossOfAllCameras) {
  Worn one(small_model_with_memory()), two(small_model_with_memory());
  one.run(1);
  two.run(2);
  const auto lose = [](Worn& worn, bool all) { worn.sends.fill(!all); };
  // What is remembered differs; after a loss of all of them nothing does.
  two.index = one.index = 200;
  one.step();
  two.step();
  EXPECT_NE(one.frame.weights, two.frame.weights);
  for (Worn* const worn : {&one, &two}) {
    lose(*worn, true);
    worn->run(0.5);
    EXPECT_EQ(worn->result.sensors_present, 0U);
    lose(*worn, false);
    worn->run(0.2);
  }
  EXPECT_EQ(one.frame.weights, two.frame.weights);
}

TEST(HeadsetTracker, AMemoryReadsAgainstTheFaceAtRest) {
  Worn worn(small_model_with_memory());
  worn.run(0.2);
  worn.stands_still.fill(false);
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + std::chrono::seconds(3));
  worn.run(3.1);
  ASSERT_EQ(worn.events.size(), 1U);
  EXPECT_EQ(worn.events[0].kind, tracker::CalibrationEvent::Kind::calibrated);
  const auto neutral = parse_neutral_face(worn.tracker->calibration(), "calibration");
  ASSERT_TRUE(neutral) << neutral.error().message();
  EXPECT_EQ(neutral->rest.features.size(), model::kViews * 8);
  EXPECT_EQ(neutral->rest.present, (Present{true, true, true, true}));

  // Another session takes it back, one with another model does not.
  Worn again(small_model_with_memory()), other(small_model());
  EXPECT_TRUE(again.tracker->restore(worn.tracker->calibration()));
  const auto refused = other.tracker->restore(worn.tracker->calibration());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::mismatch);
}

TEST(HeadsetTracker, FollowsItsPictures) {
  Worn worn;
  worn.run(0.2);
  const auto before = worn.frame.weights;
  worn.run(0.1);
  EXPECT_NE(worn.frame.weights, before);
}

TEST(HeadsetTracker, PicturesGiveTheBitsOfTheirFeatures) {
  Worn reduced, raw;
  raw.raw = true;
  for (int i = 0; i < 30; ++i) {
    reduced.step();
    raw.step();
    ASSERT_EQ(raw.frame.weights, reduced.frame.weights);
    ASSERT_EQ(raw.frame.eyes_rad, reduced.frame.eyes_rad);
    ASSERT_EQ(raw.result.sensors_present, reduced.result.sensors_present);
  }
  EXPECT_EQ(raw.result.sensors_present, 4U);
}

TEST(HeadsetTracker, ACameraWithoutPicturesIsMissing) {
  Worn worn;
  worn.run(0.3);
  worn.sends[0] = false;
  for (int i = 0; i < 6; ++i) {
    worn.step();
    EXPECT_EQ(worn.result.sensors_present, 4U) << "not yet: the newest picture is " << i + 1 << " frames old";
  }
  worn.step();
  EXPECT_EQ(worn.result.sensors_present, 3U);
  EXPECT_EQ(worn.frame.provenance[kBlinkL], Provenance::predicted);
  EXPECT_LT(worn.frame.confidence[kBlinkL], 0.35F);
  EXPECT_EQ(worn.frame.provenance[kBlinkR], Provenance::measured);
  EXPECT_EQ(worn.frame.eyes_rad[0], worn.frame.eyes_rad[1]) << "the one that is seen tells both";
  ASSERT_TRUE(worn.result.explained);
  EXPECT_LT((*worn.result.explained)[kBlinkL], 0.35F);
  // What stands for it is the network's token.
  Worn three;
  three.sends[0] = false;
  three.index = worn.index - 20;
  three.lines = worn.lines;
  three.run(20.0 / 60);
  EXPECT_EQ(three.frame.weights, worn.frame.weights);

  worn.sends = {false, false, true, false};
  worn.run(0.2);
  EXPECT_EQ(worn.result.sensors_present, 1U);
  EXPECT_EQ(worn.frame.eyes_provenance, Provenance::held);
  EXPECT_EQ(worn.frame.eyes_confidence, 0);
  EXPECT_GE(worn.frame.confidence[kJaw], 0.5F) << "one half of the mouth is seen";
  worn.sends = {};
  worn.run(0.2);
  EXPECT_EQ(worn.result.sensors_present, 0U);
  EXPECT_EQ(worn.frame.provenance[kJaw], Provenance::neutral);
  EXPECT_FALSE(worn.result.explained);
  worn.sends = {true, true, true, true};
  worn.run(0.1);
  EXPECT_EQ(worn.result.sensors_present, 4U);
}

TEST(HeadsetTracker, APictureThatStandsStillIsNone) {
  Worn worn;
  worn.run(0.2);
  worn.stands_still[2] = true;
  worn.run(2 / 60.0);
  EXPECT_EQ(worn.result.sensors_present, 4U);
  worn.step();
  EXPECT_EQ(worn.result.sensors_present, 3U);
  worn.run(0.5);
  EXPECT_EQ(worn.result.sensors_present, 3U);
  worn.stands_still[2] = false;
  worn.step();
  EXPECT_EQ(worn.result.sensors_present, 4U);
}

TEST(HeadsetTracker, TakesNoFeaturesOfAnotherPlaceOrNetwork) {
  Worn worn;
  auto other = FeatureReducer::create(headset_rig(), small_model()).value();
  Bytes record(sensor::kMaxPayload);
  record.resize(other.reduce_picture(1, grey_jpeg(64, 64, 1), record).value());
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::picture;
  worn.lines.add({}, sample);
  worn.tracker->add_with_payload({}, sample, record);
  worn.tracker->add_with_payload({}, sample, std::span(record).first(record.size() - 4));
  worn.tracker->add_with_payload({}, sample, text_bytes("neither"));
  worn.tracker->add({}, sample);
  sample.sensor = 9;
  worn.tracker->add_with_payload({}, sample, record);
  EXPECT_EQ(worn.tracker->tick(worn.now(), worn.lines, worn.frame).sensors_present, 0U);
}

TEST(HeadsetTracker, AClosedEyeKeepsItsDirectionAndIsNotSureOfIt) {
  Answer closed = telling_answer();
  closed.openness = {0.05F, 0.05F};
  Answer half = telling_answer();
  half.openness = {0.3F, 0.3F};
  Answer winking = telling_answer();
  winking.openness = {0.05F, 1};
  Worn blinks(HeadsetModel::create(constant_file(closed)).value());
  blinks.run(0.2);
  EXPECT_EQ(blinks.frame.eyes_confidence, 0);
  EXPECT_EQ(blinks.frame.eyes_provenance, Provenance::neutral) << "no direction was ever seen";
  Worn squints(HeadsetModel::create(constant_file(half)).value());
  squints.run(0.2);
  Worn open(HeadsetModel::create(constant_file(telling_answer())).value());
  open.run(0.2);
  EXPECT_GT(squints.frame.eyes_confidence, 0);
  EXPECT_LT(squints.frame.eyes_confidence, open.frame.eyes_confidence);
  Worn winks(HeadsetModel::create(constant_file(winking)).value());
  winks.run(0.2);
  EXPECT_EQ(winks.frame.eyes_confidence, open.frame.eyes_confidence) << "the open eye tells for both";
}

TEST(HeadsetTracker, WhatIsAnsweredOfAGuidedNeutralIsTakenOff) {
  Worn worn(HeadsetModel::create(constant_file(telling_answer())).value());
  worn.run(0.5);
  const tracker::Guidance wanted = worn.tracker->guidance();
  EXPECT_EQ(wanted.neutral, std::chrono::seconds(3));
  EXPECT_FALSE(wanted.gestures);
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + wanted.neutral);
  worn.run(1);
  EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::guided);
  EXPECT_NEAR(worn.frame.weights[kJaw], 0.5, 1e-5);
  worn.run(2.1);
  ASSERT_EQ(worn.events.size(), 1U);
  EXPECT_EQ(worn.events[0].kind, tracker::CalibrationEvent::Kind::calibrated);
  EXPECT_EQ(worn.events[0].modality, "camera");
  EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::done);
  EXPECT_NEAR(worn.frame.weights[kJaw], 0, 1e-5);
  EXPECT_NEAR(worn.frame.eyes_rad[0].x(), 0, 1e-5);
  EXPECT_TRUE(sensor::all_pass(worn.tracker->scores()));

  // Another session of the same wearer.
  const std::string json = worn.tracker->calibration();
  Worn next(HeadsetModel::create(constant_file(telling_answer())).value());
  ASSERT_TRUE(next.tracker->restore(json));
  next.run(0.2);
  EXPECT_EQ(next.frame.weights, worn.frame.weights);
  EXPECT_EQ(next.tracker->calibration(), json);
  EXPECT_EQ(next.tracker->restore("{}").error().code, ErrorCode::malformed);
  std::string others = json;
  others.replace(others.find("eye_L"), 5, "eye_X");
  EXPECT_EQ(next.tracker->restore(others).error().code, ErrorCode::mismatch);
  EXPECT_EQ(next.tracker->calibration(), json);
  next.tracker->forget(2);
  EXPECT_TRUE(next.tracker->calibration().empty()) << "another camera looks otherwise";
}

TEST(HeadsetTracker, AHoldWithoutPicturesLeavesWhatWasInForce) {
  Worn worn(HeadsetModel::create(constant_file(telling_answer())).value());
  worn.run(0.5);
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.sends[3] = false;
  worn.run(3.1);
  ASSERT_EQ(worn.events.size(), 1U);
  EXPECT_EQ(worn.events[0].kind, tracker::CalibrationEvent::Kind::withdrawn);
  EXPECT_TRUE(worn.tracker->calibration().empty());
  EXPECT_TRUE(worn.tracker->calibration_state().hint.starts_with("a camera gave too few pictures"));

  worn.sends[3] = true;
  worn.run(0.2);
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.tracker->guide(Step::nod, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.tracker->guide_range(worn.now() + HeadsetTracker::kNeutral, worn.now() + std::chrono::seconds(5));
  worn.run(4);
  EXPECT_FALSE(worn.tracker->calibration().empty());
  worn.tracker->cancel_guidance();
  EXPECT_TRUE(worn.tracker->calibration().empty()) << "the range still ran";
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.run(3.1);
  worn.tracker->cancel_guidance();
  EXPECT_FALSE(worn.tracker->calibration().empty()) << "it was over";
}

/// What a tracker knows of the face at rest.
RestFeatures rest_of(const HeadsetTracker& tracker) {
  return parse_wearer_calibration(tracker.calibration(), "test").value().neutral.rest;
}
/// A view's part of it.
std::vector<float> view_of(const RestFeatures& rest, std::size_t place) {
  const auto count = static_cast<std::ptrdiff_t>(rest.features.size() / model::kViews);
  const auto begin = rest.features.begin() + static_cast<std::ptrdiff_t>(place) * count;
  return {begin, begin + count};
}

TEST(HeadsetTracker, ARestReplacesTheNeutralOfTheCamerasThatAreThere) {
  Worn worn(HeadsetModel::create(constant_file(telling_answer())).value());
  worn.pictures = 4;
  worn.run(0.5);
  EXPECT_EQ(worn.tracker->wants_rest(), Duration::zero()) << "no neutral to replace";
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.run(3.1);
  ASSERT_EQ(worn.tracker->wants_rest(), HeadsetTracker::kRest);
  const RestFeatures before = rest_of(*worn.tracker);

  // The headset has slipped, and one camera falls silent after a moment.
  worn.first_picture = 20;
  worn.run(0.2);
  worn.tracker->rest(worn.now(), worn.now() + HeadsetTracker::kRest);
  worn.run(0.5);
  worn.sends[3] = false;
  worn.run(0.5);
  EXPECT_NEAR(worn.frame.weights[kJaw], 0, 1e-5) << "corrected by the neutral before";
  EXPECT_EQ(worn.tracker->calibration_state().phase, Phase::done);
  worn.run(1.1);
  ASSERT_EQ(worn.rests.size(), 1U);
  EXPECT_EQ(worn.rests[0].corrected, (std::vector<std::uint16_t>{0, 1, 2}));
  EXPECT_EQ(worn.rests[0].absent, std::vector<std::uint16_t>{3});
  EXPECT_EQ(worn.events.size(), 1U) << "no calibration event";
  EXPECT_NEAR(worn.frame.weights[kJaw], 0, 1e-5);
  const RestFeatures after = rest_of(*worn.tracker);
  EXPECT_EQ(after.present, before.present);
  for (std::size_t place = 0; place < model::kViews; ++place)
    EXPECT_EQ(view_of(after, place) == view_of(before, place), place == 3) << place;
}

TEST(HeadsetTracker, ARestThatFailsLeavesTheNeutralAsItWas) {
  Worn worn(HeadsetModel::create(constant_file(telling_answer())).value());
  worn.run(0.5);
  worn.tracker->guide(Step::neutral, worn.now(), worn.now() + HeadsetTracker::kNeutral);
  worn.run(3.1);
  const std::string before = worn.tracker->calibration();
  // No pictures.
  worn.tracker->rest(worn.now(), worn.now() + HeadsetTracker::kRest);
  worn.sends.fill(false);
  worn.run(2.1);
  ASSERT_EQ(worn.rests.size(), 1U);
  EXPECT_TRUE(worn.rests[0].corrected.empty());
  EXPECT_EQ(worn.rests[0].absent.size(), 4U);
  EXPECT_EQ(worn.tracker->calibration(), before);
  // An empty rest ends one.
  worn.sends.fill(true);
  worn.first_picture = 10;
  worn.pictures = 4;
  worn.tracker->rest(worn.now(), worn.now() + HeadsetTracker::kRest);
  worn.run(1);
  worn.tracker->rest(worn.now(), worn.now());
  worn.run(2);
  EXPECT_EQ(worn.rests.size(), 1U);
  EXPECT_EQ(worn.tracker->calibration(), before);
  // A guided hold does, and so does a camera that is another now.
  worn.tracker->rest(worn.now(), worn.now() + HeadsetTracker::kRest);
  worn.run(1);
  worn.tracker->forget(2);
  worn.run(2);
  EXPECT_EQ(worn.rests.size(), 1U);
  EXPECT_TRUE(worn.tracker->calibration().empty());
}

TEST(HeadsetTracker, AllocatesNothingOnceItRuns) {
  for (const bool raw : {false, true}) {
    Worn worn;
    worn.raw = raw;
    worn.run(0.5);
    const std::size_t before = mien::test::allocation_count();
    worn.run(0.5);
    EXPECT_EQ(mien::test::allocation_count(), before) << (raw ? "pictures" : "features");
  }
}

}  // namespace
}  // namespace mien::headset::headset_tracker_test
