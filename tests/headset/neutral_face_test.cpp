#include "mien/headset/neutral_face.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace mien::headset::neutral_face_test {
namespace {

const std::size_t kJaw = face::shape("jawOpen"), kSmile = face::shape("mouthSmile_L");

Answer resting(float jaw = 0.2F) {
  Answer answer;
  answer.weights[kJaw] = jaw;
  answer.gaze_rad = {0.1F, -0.05F, 0.02F, -0.1F};
  answer.openness = {0.8F, 1.0F};
  return answer;
}

/// All but the jaw moved by `far`; 1 is far from rest.
Answer moving(float jaw, float far = 1) {
  Answer answer = resting(jaw);
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (k != kJaw) answer.weights[k] = far;
  return answer;
}

constexpr std::size_t kFeatures = 3;
/// Of all views but the right half of the mouth's.
MomentFeatures seen(float value) {
  return {.features = std::vector<float>(model::kViews * kFeatures, value),
          .present = {true, true, true, false},
          .age_s = {}};
}

NeutralFace made_of(const std::vector<Answer>& answers) {
  NeutralMaker maker(kFeatures);
  maker.begin();
  float value = 0;
  for (const Answer& answer : answers) maker.add(seen(value++), answer);
  NeutralFace made = maker.make({"eye_L", "mouth_M"});
  made.network = "hash";
  return made;
}

TEST(NeutralFace, KeepsTheMeanOfWhatIsFound) {
  const NeutralFace neutral = made_of({resting(), resting(), resting()});
  EXPECT_EQ(neutral.rest.present, (Present{true, true, true, false}));
  ASSERT_EQ(neutral.rest.features.size(), model::kViews * kFeatures);
  EXPECT_FLOAT_EQ(neutral.rest.features[0], 1);
  EXPECT_FLOAT_EQ(neutral.rest.features.back(), 0);
}

TEST(NeutralFace, CorrectsByWhatIsAnsweredOfTheFaceAtRest) {
  NeutralFace neutral = made_of({resting(0.4F)});
  Answer still;
  still.weights[kJaw] = 0.1F;
  still.gaze_rad[1] = 9;
  neutral.correct_by(still);
  EXPECT_FLOAT_EQ(neutral.weights[kJaw], 0.1F);
  EXPECT_LT(neutral.gaze_rad[1], 2) << "held to what it can be";
}

TEST(NeutralFace, TakesAllOffAtRest) {
  const NeutralFace neutral = made_of({resting(0.3F), resting(0.3F)});
  Answer answer = resting(0.3F);
  neutral.correct(answer);
  EXPECT_NEAR(answer.weights[kJaw], 0, 1e-6);
  for (const float angle_rad : answer.gaze_rad) EXPECT_NEAR(angle_rad, 0, 1e-6);
  EXPECT_NEAR(answer.openness[0], 1, 1e-6);
}

TEST(NeutralFace, TakesFromAMovingFaceWhatIsUnusualAtRest) {
  constexpr float kUnusual = 0.3F - NeutralFace::kUsualAtRest, kGaze_rad = 0.1F - NeutralFace::kUsualGaze_rad;
  const NeutralFace neutral = made_of({resting(0.3F), resting(0.3F)});
  Answer answer = moving(0.3F);
  neutral.correct(answer);
  EXPECT_NEAR(answer.weights[kJaw], NeutralFace::kUsualAtRest / (1 - kUnusual), 1e-5);
  EXPECT_NEAR(answer.weights[kSmile], 1, 1e-5);
  EXPECT_NEAR(answer.gaze_rad[0], NeutralFace::kUsualGaze_rad, 1e-5);
  EXPECT_NEAR(answer.gaze_rad[1], -0.05F, 1e-5) << "a usual one stays";
  EXPECT_NEAR(answer.gaze_rad[3], -NeutralFace::kUsualGaze_rad, 1e-5);
  answer = moving(1);
  answer.openness = {0, 1.4F};
  answer.gaze_rad[0] = 0.3F;
  neutral.correct(answer);
  EXPECT_FLOAT_EQ(answer.weights[kJaw], 1) << "the end of the way stays";
  EXPECT_NEAR(answer.gaze_rad[0], 0.3F - kGaze_rad, 1e-5);
  EXPECT_EQ(answer.openness[0], 0);
  EXPECT_NEAR(answer.openness[1], 1.4, 1e-6);
  answer = moving(0.5F * kUnusual);
  neutral.correct(answer);
  EXPECT_EQ(answer.weights[kJaw], 0) << "less than that is nothing";
}

TEST(NeutralFace, LeavesTheUsualTheMoreTheFartherTheFaceIsFromRest) {
  const NeutralFace neutral = made_of({resting(NeutralFace::kUsualAtRest)});
  float before = 0;
  for (const float far : {0.0F, 0.02F, 0.05F, 0.1F, 0.2F, 1.0F}) {
    Answer answer = moving(NeutralFace::kUsualAtRest, far);
    neutral.correct(answer);
    EXPECT_GE(answer.weights[kJaw], before);
    before = answer.weights[kJaw];
  }
  EXPECT_NEAR(before, NeutralFace::kUsualAtRest, 0.01);
  // At that distance 1/e of it is off.
  Answer near = moving(NeutralFace::kUsualAtRest,
                       NeutralFace::kNearRest * std::sqrt(face::kShapeCount / (face::kShapeCount - 1.0F)));
  neutral.correct(near);
  EXPECT_NEAR(near.weights[kJaw], NeutralFace::kUsualAtRest * (1 - std::exp(-1.0F)), 0.01);
}

TEST(NeutralFace, IsJudged) {
  const auto passes = [](const NeutralFace& neutral) {
    return std::pair(neutral.scores.at(0).pass, neutral.scores.at(1).pass);
  };
  EXPECT_EQ(passes(made_of({resting(), resting()})), std::pair(true, true));
  Answer wild;
  wild.weights.values.fill(0.3F);
  EXPECT_EQ(passes(made_of({resting(), wild, resting(), wild})), std::pair(false, true));
  const NeutralFace tense = made_of({resting(0.9F), resting(0.9F)});
  EXPECT_EQ(passes(tense), std::pair(true, false));
  EXPECT_TRUE(tense.scores[1].sentence.starts_with("jawOpen had so much at rest"));
  EXPECT_EQ(tense.weights[kJaw], NeutralFace::kMostAtRest);
}

TEST(NeutralFace, ReadsWhatItWrites) {
  const NeutralFace neutral = made_of({resting(0.31F), resting(0.5F)});
  const auto back = parse_neutral_face(write_neutral_face(neutral), "calibration");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, neutral);
}

nlohmann::json json_of_another_kind(std::string_view key) {
  return key == "network" ? nlohmann::json(3) : nlohmann::json("text");
}

TEST(NeutralFace, RefusesWhatIsNone) {
  const std::string sound = write_neutral_face(made_of({resting()}));
  const auto code = [&](const auto& edit) {
    nlohmann::json root = nlohmann::json::parse(sound);
    edit(root);
    const auto parsed = parse_neutral_face(root.dump(), "calibration");
    return parsed ? std::optional<ErrorCode>() : parsed.error().code;
  };
  EXPECT_FALSE(code([](nlohmann::json&) {}));
  EXPECT_EQ(code([](nlohmann::json& j) { j = 3; }), ErrorCode::malformed);
  for (const char* key : {"cameras", "weights", "tongue_out", "gaze_rad", "openness", "scores", "features",
                          "seen", "network"}) {
    EXPECT_EQ(code([&](nlohmann::json& j) { j.erase(key); }), ErrorCode::malformed) << key;
    EXPECT_EQ(code([&](nlohmann::json& j) { j[key] = json_of_another_kind(key); }), ErrorCode::malformed)
        << key;
  }
  EXPECT_EQ(code([](nlohmann::json& j) { j["weights"].push_back(0); }), ErrorCode::malformed);
  EXPECT_EQ(code([](nlohmann::json& j) { j["weights"][3] = "x"; }), ErrorCode::malformed);
  EXPECT_EQ(code([](nlohmann::json& j) { j["weights"][3] = 0.7; }), ErrorCode::out_of_range);
  EXPECT_EQ(code([](nlohmann::json& j) { j["openness"][0] = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code([](nlohmann::json& j) { j["gaze_rad"][0] = 1e300; }), ErrorCode::out_of_range);
  EXPECT_EQ(code([](nlohmann::json& j) { j["cameras"][0] = 1; }), ErrorCode::malformed);
  EXPECT_EQ(code([](nlohmann::json& j) { j["features"].push_back(0); }), ErrorCode::malformed);
  EXPECT_EQ(code([](nlohmann::json& j) { j["features"][0] = 1e9; }), ErrorCode::out_of_range);
  EXPECT_EQ(code([](nlohmann::json& j) { j["seen"][0] = 1; }), ErrorCode::malformed);
  EXPECT_EQ(code([](nlohmann::json& j) { j["seen"].push_back(true); }), ErrorCode::malformed);
  EXPECT_FALSE(parse_neutral_face("{", "calibration"));
}

}  // namespace
}  // namespace mien::headset::neutral_face_test
