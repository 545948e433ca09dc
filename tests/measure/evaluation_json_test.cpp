#include "mien/measure/evaluation_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace mien::measure::evaluation_json_test {
namespace {

Evaluation some_evaluation() {
  Evaluation evaluation;
  evaluation.frames = 120;
  evaluation.takes = 2;
  evaluation.model.mse = 0.25;
  evaluation.model.mse_observed = 0.125;
  evaluation.model.pve_mm = {0.75, 0.5};
  evaluation.model.pve_face_mm = MeanStd{1.5, 1};
  evaluation.model.lmk_mm = MeanStd{2.5, 2};
  evaluation.model.jitter_ratio = 1.25;
  evaluation.model.blink_f1 = 0.875;
  evaluation.model.eyes_and_lips =
      EyesAndLips{.gaze_deg = EyesAndLips::Angle{2.5, 7.5}, .openness_pearson = 0.75, .lip_gap_f1 = 0.5};
  evaluation.mean_pose.eyes_and_lips =
      EyesAndLips{.gaze_deg = EyesAndLips::Angle{8, 9}, .openness_pearson = {}, .lip_gap_f1 = 0.25};
  evaluation.model.about_rest = MotionErrors{.mse = 0.5, .pve_mm = 0.25};
  evaluation.wears = Wears{.count = 5, .pve_mm = {2, 1, 3}, .mse = {0.5, 0.25, 0.75}};
  evaluation.ece = 0.0625;
  evaluation.model.per_shape[face::shape("jawOpen")] = {0.0625, 0.5};
  evaluation.mean_pose.mse = 1;
  evaluation.hold_last.mse = 2;
  evaluation.ridge = Metrics{};
  evaluation.ridge->mse = 3;
  evaluation.provenance.emplace()[face::shape("jawOpen")] = {0.75, 0, 0.25, 0, 0, 0};
  return evaluation;
}

EvaluationContext some_context() {
  return {.face = "builtin", .model = "m.safetensors", .devices = "lab", .steps = 4};
}

TEST(EvaluationJson, HasWhatTheContractNames) {
  const auto json = nlohmann::json::parse(evaluation_json(some_evaluation(), some_context()));
  EXPECT_EQ(json["frames"], 120);
  EXPECT_EQ(json["takes"], 2);
  EXPECT_EQ(json["face"], "builtin");
  EXPECT_EQ(json["devices"], "lab");
  EXPECT_EQ(json["steps"], 4);
  EXPECT_EQ(json["adapted"], false);
  const auto& model = json["model"];
  EXPECT_EQ(model["mse"], 0.25);
  EXPECT_EQ(model["mse_observed"], 0.125);
  EXPECT_EQ(model["pve_mm"], (nlohmann::json{{"mean", 0.75}, {"std", 0.5}}));
  EXPECT_EQ(model["pve_face_mm"]["mean"], 1.5);
  EXPECT_EQ(model["lmk_mm"]["std"], 2);
  EXPECT_EQ(model["jitter_ratio"], 1.25);
  EXPECT_EQ(model["blink_f1"], 0.875);
  EXPECT_EQ(model["gaze_deg"], (nlohmann::json{{"median", 2.5}, {"p90", 7.5}}));
  EXPECT_EQ(model["openness_pearson"], 0.75);
  EXPECT_EQ(model["lip_gap_f1"], 0.5);
  EXPECT_EQ(model["about_rest"], (nlohmann::json{{"mse", 0.5}, {"pve_mm", 0.25}}));
  EXPECT_EQ(json["wears"]["count"], 5);
  EXPECT_EQ(json["wears"]["pve_mm"], (nlohmann::json{{"mean", 2}, {"low", 1}, {"high", 3}}));
  EXPECT_TRUE(json["wears"]["about_rest"].contains("mse"));
  EXPECT_EQ(model["ece"], 0.0625);
  EXPECT_EQ(json["baselines"]["mean_pose"]["gaze_deg"]["median"], 8);
  EXPECT_FALSE(json["baselines"]["mean_pose"].contains("ece")) << "a pose claims nothing";
  EXPECT_EQ(model["per_shape"].size(), face::kShapeCount);
  EXPECT_EQ(model["per_shape"]["jawOpen"], (nlohmann::json{{"mae", 0.0625}, {"pearson", 0.5}}));
  EXPECT_EQ(json["provenance"].size(), face::kShapeCount);
  EXPECT_EQ(json["provenance"]["jawOpen"], (nlohmann::json{{"measured", 0.75}, {"predicted", 0.25}}));
  EXPECT_EQ(json["baselines"]["mean_pose"]["mse"], 1);
  EXPECT_EQ(json["baselines"]["hold_last"]["mse"], 2);
  EXPECT_EQ(json["baselines"]["ridge"]["mse"], 3);
}

TEST(EvaluationJson, WhatTheDataLackIsNull) {
  Evaluation evaluation = some_evaluation();
  evaluation.ridge.reset();
  evaluation.provenance.reset();
  evaluation.model.lmk_mm.reset();
  evaluation.model.pve_face_mm.reset();
  evaluation.model.jitter_ratio.reset();
  evaluation.model.blink_f1.reset();
  evaluation.model.eyes_and_lips = EyesAndLips{};
  evaluation.ece.reset();
  const auto json = nlohmann::json::parse(evaluation_json(evaluation, some_context()));
  EXPECT_TRUE(json["baselines"]["ridge"].is_null());
  EXPECT_TRUE(json["provenance"].is_null());
  for (const char* key : {"lmk_mm", "pve_face_mm", "jitter_ratio", "blink_f1", "gaze_deg", "openness_pearson",
                          "lip_gap_f1", "ece"}) {
    ASSERT_TRUE(json["model"].contains(key)) << key;
    EXPECT_TRUE(json["model"][key].is_null()) << key;
  }
  EXPECT_TRUE(json["model"]["per_shape"]["mouthLeft"]["pearson"].is_null());
}

TEST(EvaluationJson, NamesPerformancesThatTheModelWasTrainedOn) {
  EvaluationContext context = some_context();
  EXPECT_TRUE(caveats(context).empty());
  EXPECT_TRUE(nlohmann::json::parse(evaluation_json(some_evaluation(), context))["trained_on"].empty());
  context.trained_on = {"alex.csv"};
  ASSERT_EQ(caveats(context).size(), 1U);
  EXPECT_NE(caveats(context).front().find("alex.csv"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(evaluation_json(some_evaluation(), context))["trained_on"][0], "alex.csv");
}

TEST(EvaluationJson, APathOfAnyBytesDoesNotBreakIt) {
  EvaluationContext context = some_context();
  context.model = "mod\xE9le.safetensors";
  context.face = "a\"b\\c";
  const auto json = nlohmann::json::parse(evaluation_json(some_evaluation(), context));
  EXPECT_EQ(json["face"], "a\"b\\c");
  EXPECT_EQ(json["model_file"], "mod\xEF\xBF\xBDle.safetensors");
}

}  // namespace
}  // namespace mien::measure::evaluation_json_test
