#include "mien/measure/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/time.h"
#include "mien/measure/evaluation.h"

namespace mien::measure {
namespace {

using Errors = std::array<double, face::kShapeCount>;

/// Estimate less truth of each shape, both clipped to [0, 1].
Errors errors_of(const face::BlendshapeWeights& estimate, const face::BlendshapeWeights& truth) {
  Errors errors{};
  for (std::size_t k = 0; k < errors.size(); ++k)
    errors[k] = std::clamp(estimate[k], 0.0F, 1.0F) - double{std::clamp(truth[k], 0.0F, 1.0F)};
  return errors;
}

double mean_square(const Errors& errors) {
  double sum = 0;
  for (const double error : errors) sum += error * error;
  return sum / static_cast<double>(errors.size());
}

}  // namespace

std::vector<Piece> pieces_of(std::span<const take::TruthFrame> truth,
                             std::span<const face::BlendshapeWeights> estimate,
                             const face::BlendshapeWeights& mean_pose, double length_s) {
  const auto length = static_cast<std::size_t>(std::max(1.0, std::round(length_s * kFrameRateHz)));
  std::vector<Piece> pieces;
  std::vector<Errors> bias;
  std::size_t first = 0;
  for (const auto& [begin, end] : evaluated_runs(truth)) {
    if (pieces.empty()) first = begin;
    for (std::size_t i = begin; i < end; ++i) {
      const double begin_s = static_cast<double>((i - first) / length * length) / kFrameRateHz;
      if (pieces.empty() || pieces.back().begin_s < begin_s) {
        pieces.push_back({.begin_s = begin_s});
        bias.emplace_back();
      }
      Piece& piece = pieces.back();
      ++piece.frames;
      const Errors errors = errors_of(estimate[i], truth[i].weights);
      piece.mse += mean_square(errors);
      piece.mean_pose_mse += mean_square(errors_of(mean_pose, truth[i].weights));
      for (std::size_t k = 0; k < errors.size(); ++k) bias.back()[k] += errors[k];
    }
  }
  if (pieces.size() > 1 && 2 * pieces.back().frames < length) pieces.pop_back();
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    Piece& piece = pieces[p];
    const auto frames = static_cast<double>(piece.frames);
    piece.mse /= frames;
    piece.mean_pose_mse /= frames;
    for (double& one : bias[p]) one /= frames;
    const double at_first = pieces.front().mse * piece.mean_pose_mse;
    if (at_first > 0) piece.ratio = piece.mse * pieces.front().mean_pose_mse / at_first;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (const double by = bias[p][k] - bias[0][k]; std::abs(by) > std::abs(piece.bias)) {
        piece.bias = by;
        piece.biased_shape = k;
      }
  }
  return pieces;
}

}  // namespace mien::measure
