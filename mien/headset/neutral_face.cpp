#include "mien/headset/neutral_face.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "mien/headset/feature_record.h"
#include "mien/sensor/calibration_json.h"

namespace mien::headset {
namespace {

using nlohmann::json;

constexpr std::size_t kMostScores = 1024;
constexpr std::size_t kMostCameras = 256;
constexpr float kMostOpenness = 1.5F;
/// Mean over the shapes of each one's standard deviation, beyond which a face did not hold still.
constexpr double kRestless = 0.04;
/// A weight that is taken for more at rest was no rest, or is not understood.
constexpr double kNotAtRest = 0.5;

/// Of what is answered at rest, what is taken off: all beyond the usual, and that by `near_rest` (0 to 1).
float taken_off(float at_rest, float usual, float near_rest) {
  const float most_usual = std::clamp(at_rest, -usual, usual);
  return at_rest - most_usual + near_rest * most_usual;
}

float beyond_rest(float weight, float at_rest, float near_rest) {
  const float off = taken_off(at_rest, NeutralFace::kUsualAtRest, near_rest);
  return std::clamp((weight - off) / (1 - off), 0.0F, 1.0F);
}

/// An array of so many numbers within a range.
Result<void> read_numbers(const json& root, const char* key, float least, float most, std::span<float> out,
                          const std::string& where) {
  const auto found = root.find(key);
  if (found == root.end() || !found->is_array() || found->size() != out.size())
    return fail(ErrorCode::malformed, fmt::format("'{}' is no list of {} numbers", key, out.size()), where);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!(*found)[i].is_number())
      return fail(ErrorCode::malformed, fmt::format("'{}' is no list of numbers", key), where);
    const double value = (*found)[i].get<double>();
    if (!(value >= double{least} && value <= double{most}))
      return fail(ErrorCode::out_of_range,
                  fmt::format("'{}' has {}, which is not within {} to {}", key, value, least, most), where);
    out[i] = static_cast<float>(value);
  }
  return {};
}

Result<void> read_rest(const json& root, NeutralFace& neutral, const std::string& where) {
  const auto network = root.find("network"), features = root.find("features"), seen = root.find("seen");
  if (network == root.end() || !network->is_string())
    return fail(ErrorCode::malformed, "'network' is no text", where);
  neutral.network = network->get<std::string>();
  if (features == root.end() || !features->is_array() || features->size() % model::kViews != 0 ||
      features->size() > model::kViews * kMostFeatures)
    return fail(ErrorCode::malformed, "'features' is no list of what views show", where);
  neutral.rest.features.resize(features->size());
  MIEN_TRY(read_numbers(root, "features", -kMostFeature, kMostFeature, neutral.rest.features, where));
  if (seen == root.end() || !seen->is_array() || seen->size() != model::kViews ||
      !std::ranges::all_of(*seen, [](const json& view) { return view.is_boolean(); }))
    return fail(ErrorCode::malformed, fmt::format("'seen' is no list of {} truths", model::kViews), where);
  for (std::size_t v = 0; v < model::kViews; ++v) neutral.rest.present[v] = (*seen)[v].get<bool>();
  return {};
}

}  // namespace

void NeutralFace::correct(Answer& answer) const {
  float square = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const float away = answer.weights[k] - weights[k];
    square += away * away / float{face::kShapeCount};
  }
  const float near_rest = std::exp(-square / (kNearRest * kNearRest));
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    answer.weights[k] = beyond_rest(answer.weights[k], weights[k], near_rest);
  answer.tongue_out = beyond_rest(answer.tongue_out, tongue_out, near_rest);
  for (std::size_t i = 0; i < gaze_rad.size(); ++i)
    answer.gaze_rad[i] -= taken_off(gaze_rad[i], kUsualGaze_rad, near_rest);
  for (std::size_t e = 0; e < openness.size(); ++e)
    answer.openness[e] = std::min(answer.openness[e] / openness[e], kMostOpenness);
}

void NeutralFace::correct_by(const Answer& at_rest) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    weights[k] = std::clamp(at_rest.weights[k], 0.0F, kMostAtRest);
  tongue_out = std::clamp(at_rest.tongue_out, 0.0F, kMostAtRest);
  for (std::size_t i = 0; i < gaze_rad.size(); ++i)
    gaze_rad[i] = std::clamp(at_rest.gaze_rad[i], -kMostGaze_rad, kMostGaze_rad);
  for (std::size_t e = 0; e < openness.size(); ++e)
    openness[e] = std::clamp(at_rest.openness[e], kLeastOpenness, kMostOpenness);
}

std::string write_neutral_face(const NeutralFace& neutral) {
  return json({{"cameras", neutral.cameras},
               {"weights", neutral.weights.values},
               {"tongue_out", std::array{neutral.tongue_out}},
               {"gaze_rad", neutral.gaze_rad},
               {"openness", neutral.openness},
               {"features", neutral.rest.features},
               {"seen", neutral.rest.present},
               {"network", neutral.network},
               {"scores", sensor::scores_json(neutral.scores)}})
      .dump();
}

Result<NeutralFace> parse_neutral_face(std::string_view text, const std::string& where) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return fail(ErrorCode::malformed, "not a JSON object", where);
  NeutralFace neutral;
  const auto cameras = root.find("cameras");
  if (cameras == root.end() || !cameras->is_array())
    return fail(ErrorCode::malformed, "'cameras' is no list of names", where);
  const auto scores = root.find("scores");
  if (scores == root.end() || !scores->is_array())
    return fail(ErrorCode::malformed, "'scores' is no list of scores", where);
  if (cameras->size() > kMostCameras || scores->size() > kMostScores)
    return fail(ErrorCode::out_of_range, "more cameras or scores than a rig has", where);
  for (const json& name : *cameras) {
    if (!name.is_string()) return fail(ErrorCode::malformed, "'cameras' is no list of names", where);
    neutral.cameras.push_back(name.get<std::string>());
  }
  MIEN_TRY(read_numbers(root, "weights", 0, NeutralFace::kMostAtRest, neutral.weights.values, where));
  MIEN_TRY(read_numbers(root, "tongue_out", 0, NeutralFace::kMostAtRest, {&neutral.tongue_out, 1}, where));
  MIEN_TRY(read_numbers(root, "gaze_rad", -kMostGaze_rad, kMostGaze_rad, neutral.gaze_rad, where));
  MIEN_TRY(
      read_numbers(root, "openness", NeutralFace::kLeastOpenness, kMostOpenness, neutral.openness, where));
  MIEN_TRY(read_rest(root, neutral, where));
  MIEN_TRY_ASSIGN(neutral.scores, sensor::read_scores(*scores, where));
  return neutral;
}

void NeutralMaker::begin() {
  frames_ = 0;
  std::ranges::fill(features_, 0.0);
  seen_ = {};
  ages_s_ = {};
  sum_ = squares_ = {};
}

void NeutralMaker::add(const MomentFeatures& moment, const Answer& answer) {
  const std::size_t each = features_.size() / model::kViews;
  for (std::size_t v = 0; v < model::kViews; ++v) {
    if (!moment.present[v]) continue;
    ++seen_[v];
    ages_s_[v] += double{moment.age_s[v]};
    for (std::size_t i = v * each; i < (v + 1) * each; ++i) features_[i] += double{moment.features[i]};
  }
  const auto add_to = [this](std::size_t place, float value) {
    sum_[place] += double{value};
    squares_[place] += double{value} * double{value};
  };
  for (std::size_t k = 0; k < face::kShapeCount; ++k) add_to(k, answer.weights[k]);
  add_to(kTongueOutput, answer.tongue_out);
  for (std::size_t i = 0; i < answer.gaze_rad.size(); ++i) add_to(kGazeOutput + i, answer.gaze_rad[i]);
  for (std::size_t e = 0; e < answer.openness.size(); ++e) add_to(kOpennessOutput + e, answer.openness[e]);
  ++frames_;
}

std::array<float, model::kViews> NeutralMaker::mean_age_s() const {
  std::array<float, model::kViews> ages_s{};
  for (std::size_t v = 0; v < model::kViews; ++v)
    ages_s[v] = static_cast<float>(ages_s_[v] / std::max(1.0, static_cast<double>(seen_[v])));
  return ages_s;
}

NeutralFace NeutralMaker::make(std::vector<std::string> cameras) const {
  const auto count = static_cast<double>(frames_);
  const auto mean = [&](std::size_t place) { return sum_[place] / count; };
  NeutralFace neutral;
  neutral.cameras = std::move(cameras);
  const std::size_t each = features_.size() / model::kViews;
  for (std::size_t v = 0; v < model::kViews; ++v) neutral.rest.present[v] = seen_[v] > 0;
  for (std::size_t i = 0; i < features_.size(); ++i)
    neutral.rest.features.push_back(
        static_cast<float>(features_[i] / std::max(1.0, static_cast<double>(seen_[i / each]))));
  Answer at_rest;
  double restless = 0, most = 0;
  std::size_t which = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    at_rest.weights[k] = static_cast<float>(mean(k));
    restless += std::sqrt(std::max(0.0, squares_[k] / count - mean(k) * mean(k))) / face::kShapeCount;
    // Where the eyes look is no tension of the face.
    if (face::kShapeNames[k].starts_with("eyeLook") || mean(k) <= most) continue;
    most = mean(k);
    which = k;
  }
  at_rest.tongue_out = static_cast<float>(mean(kTongueOutput));
  for (std::size_t i = 0; i < at_rest.gaze_rad.size(); ++i)
    at_rest.gaze_rad[i] = static_cast<float>(mean(kGazeOutput + i));
  for (std::size_t e = 0; e < at_rest.openness.size(); ++e)
    at_rest.openness[e] = static_cast<float>(mean(kOpennessOutput + e));
  neutral.correct_by(at_rest);
  const bool still = restless <= kRestless, rests = most <= kNotAtRest;
  neutral.scores.push_back({.name = "neutral face",
                            .value = 100 * restless,
                            .unit = "%",
                            .pass = still,
                            .sentence = still ? "how much a weight wandered on average: the face held still"
                                              : "the face moved; relax, hold still and calibrate again"});
  neutral.scores.push_back(
      {.name = "face at rest",
       .value = 100 * most,
       .unit = "%",
       .pass = rests,
       .sentence = rests ? fmt::format("the most that any shape had, {}", face::kShapeNames[which])
                         : fmt::format("{} had so much at rest; relax, or see to how the headset sits, and "
                                       "calibrate again",
                                       face::kShapeNames[which])});
  return neutral;
}

}  // namespace mien::headset
