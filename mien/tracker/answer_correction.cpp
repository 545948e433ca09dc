#include "mien/tracker/answer_correction.h"

#include <algorithm>
#include <array>

namespace mien::tracker {

AnswerCorrection::AnswerCorrection(const model::Correction& correction)
    : lags_(correction.lags), columns_(correction.weights.size()), used_(lags_.size() * face::kShapeCount) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const float weight = correction.weights[k * used_.size() + i];
      columns_[i * face::kShapeCount + k] = weight;
      if (weight != 0) used_[i] = 1;
    }
}

void AnswerCorrection::apply(History& history, face::BlendshapeWeights& weights) const {
  const std::size_t size = history.answers_.size();
  if (history.frames_ == 0) std::ranges::fill(history.answers_, weights);
  history.answers_[history.frames_ % size] = weights;
  std::array<float, face::kShapeCount> sum = weights.values;
  const float* column = columns_.data();
  for (std::size_t l = 0; l < lags_.size(); ++l) {
    const face::BlendshapeWeights& answer = history.answers_[(history.frames_ + size - lags_[l]) % size];
    for (std::size_t i = 0; i < face::kShapeCount; ++i, column += face::kShapeCount) {
      if (used_[l * face::kShapeCount + i] == 0) continue;
      const float value = answer[i];
      for (std::size_t k = 0; k < face::kShapeCount; ++k) sum[k] += column[k] * value;
    }
  }
  ++history.frames_;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) weights[k] = std::clamp(sum[k], 0.0F, 1.0F);
}

}  // namespace mien::tracker
