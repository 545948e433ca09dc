#include "mien/headset/moment_features.h"

#include <algorithm>

#include "mien/core/logistic.h"

namespace mien::headset {

void features_from_rest(const MomentFeatures& moment, const RestFeatures& rest, std::span<float> out) {
  std::ranges::fill(out, 0.0F);
  if (rest.features.size() != moment.features.size()) return;
  const std::size_t each = moment.features.size() / model::kViews;
  for (std::size_t v = 0; v < model::kViews; ++v) {
    if (!moment.present[v] || !rest.present[v]) continue;
    for (std::size_t i = v * each; i < (v + 1) * each; ++i) out[i] = moment.features[i] - rest.features[i];
  }
}

void read_moment(const model::ViewsNetwork& network, const MomentFeatures& moment, const RestFeatures& rest,
                 model::ViewsNetwork::Workspace& workspace, std::span<float> condition) {
  const std::size_t count = moment.features.size();
  std::ranges::copy(moment.features, condition.begin());
  const std::span<float> differences = condition.subspan(count, count);
  features_from_rest(moment, rest, differences);
  const std::span<float> views = condition.subspan(2 * count);
  for (std::size_t v = 0; v < model::kViews; ++v) {
    const bool there = moment.present[v];
    views[v] = there ? std::clamp(moment.age_s[v] / kOldest_s, 0.0F, 1.0F) : 1.0F;
    views[model::kViews + v] = there ? 1.0F : 0.0F;
  }
  views[2 * model::kViews] = rest.features.empty() ? 0.0F : 1.0F;
  network.answer(moment.features, differences, workspace, condition.last(kAnswerOutputs));
}

void add_moment_answer(std::span<const float> condition, std::span<float, kMemoryOutputs> outputs) {
  const std::span<const float> answer = condition.last(kAnswerOutputs);
  std::array<float, kJudgements> wrong{};
  for (std::size_t j = 0; j < wrong.size(); ++j) wrong[j] = logistic(-outputs[kAnswerOutputs + j]);
  for (std::size_t i = 0; i < answer.size(); ++i)
    outputs[i] = answer[i] + wrong[judgement_of(i)] * outputs[i];
}

std::size_t half_of_face(std::size_t judgement) {
  if (judgement == kGazeJudgement) return 0;
  const auto region = static_cast<face::ShapeRegion>(judgement);
  return region == face::ShapeRegion::brows || region == face::ShapeRegion::eyes ? 0 : 1;
}

std::size_t judgement_of(std::size_t output) {
  if (output < face::kShapeCount) return static_cast<std::size_t>(face::kShapeRegions[output]);
  if (output == kTongueOutput) return static_cast<std::size_t>(face::ShapeRegion::jaw);
  return output < kOpennessOutput ? kGazeJudgement : static_cast<std::size_t>(face::ShapeRegion::eyes);
}

const std::array<std::vector<std::size_t>, kJudgements>& judged_outputs() {
  static const std::array<std::vector<std::size_t>, kJudgements> kOutputs = [] {
    std::array<std::vector<std::size_t>, kJudgements> outputs;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      outputs[static_cast<std::size_t>(face::kShapeRegions[k])].push_back(k);
    for (std::size_t i = 0; i < 4; ++i) outputs[kGazeJudgement].push_back(kGazeOutput + i);
    return outputs;
  }();
  return kOutputs;
}

float right_output_error(std::size_t judgement) {
  std::array<float, kAnswerOutputs> least{}, most{};
  Answer answer;
  encode_answer(answer, least);
  answer.weights[0] += kRightWeight;
  answer.gaze_rad[0] += kRightGaze_rad;
  encode_answer(answer, most);
  const std::size_t output = judgement == kGazeJudgement ? kGazeOutput : 0;
  return most[output] - least[output];
}

}  // namespace mien::headset
