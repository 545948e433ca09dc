#include "mien/measure/pieces.h"

#include <algorithm>
#include <cmath>

#include "mien/core/time.h"
#include "mien/measure/evaluation.h"
#include "mien/measure/weight_errors.h"

namespace mien::measure {

std::vector<Piece> pieces_of(std::span<const take::TruthFrame> truth,
                             std::span<const face::BlendshapeWeights> estimate,
                             const face::BlendshapeWeights& mean_pose, double length_s) {
  struct Errors {
    std::size_t number = 0;
    WeightErrors model = {}, mean_pose = {};
  };
  const auto length = static_cast<std::size_t>(std::max(1.0, std::round(length_s * kFrameRateHz)));
  std::vector<Errors> errors;
  std::size_t first = 0;
  for (const auto& [begin, end] : evaluated_runs(truth)) {
    if (errors.empty()) first = begin;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t number = (i - first) / length;
      if (errors.empty() || errors.back().number < number) errors.push_back({.number = number});
      errors.back().model.add(estimate[i], truth[i].weights);
      errors.back().mean_pose.add(mean_pose, truth[i].weights);
    }
  }
  if (errors.size() > 1 && 2 * errors.back().model.frames() < length) errors.pop_back();
  std::vector<Piece> pieces;
  for (const Errors& of : errors) {
    Piece& piece = pieces.emplace_back();
    piece.begin_s = static_cast<double>(of.number * length) / kFrameRateHz;
    piece.frames = of.model.frames();
    piece.mse = of.model.mse();
    piece.mean_pose_mse = of.mean_pose.mse();
    const double at_first = pieces.front().mse * piece.mean_pose_mse;
    if (at_first > 0) piece.ratio = piece.mse * pieces.front().mean_pose_mse / at_first;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (const double by = of.model.bias(k) - errors.front().model.bias(k);
          std::abs(by) > std::abs(piece.bias)) {
        piece.bias = by;
        piece.biased_shape = k;
      }
  }
  return pieces;
}

}  // namespace mien::measure
