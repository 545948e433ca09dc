#include "mien/train/optimiser.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mien::train {
namespace {

constexpr double kBetaMean = 0.9, kBetaSquare = 0.999, kEpsilon = 1e-8;

/// Muon's momentum; what a step's numbers measure in the root of the mean square, as Adam's do.
constexpr double kMomentum = 0.95, kStepSize = 0.2;

/// The nearest matrix whose singular values are about 1 (0.7 to 1.2), by five steps of an iteration after
/// Newton and Schulz whose factors are Jordan's.
torch::Tensor orthogonalise(const torch::Tensor& matrix) {
  constexpr double kA = 3.4445, kB = -4.775, kC = 2.0315;
  const bool tall = matrix.size(0) > matrix.size(1);
  torch::Tensor x = tall ? matrix.t() : matrix;
  x = x / (x.norm() + 1e-7);
  for (int i = 0; i < 5; ++i) {
    const torch::Tensor squares = torch::mm(x, x.t());
    x = kA * x + torch::mm(kB * squares + kC * torch::mm(squares, squares), x);
  }
  return tall ? x.t() : x;
}

}  // namespace

Adam::Adam(const Parameters& parameters, std::vector<bool> orthogonal) : orthogonal_(std::move(orthogonal)) {
  orthogonal_.resize(parameters.size(), false);
  for (const torch::Tensor& p : parameters) {
    mean.push_back(torch::zeros_like(p));
    square.push_back(torch::zeros_like(p));
  }
}

void Adam::step(Parameters& parameters, double learning_rate, double clip_norm) {
  const at::NoGradGuard no_gradients;
  ++steps;
  Parameters gradients;
  for (torch::Tensor& p : parameters) {
    gradients.push_back(p.grad());
    p.mutable_grad().reset();
  }
  if (clip_norm > 0) {
    torch::Tensor sum = torch::zeros({}, gradients[0].options());
    for (const torch::Tensor& g : gradients) sum += g.square().sum();
    const torch::Tensor factor = (clip_norm / (sum.sqrt() + 1e-6)).clamp_max(1.0);
    for (torch::Tensor& g : gradients) g.mul_(factor);
  }
  const double mean_fill = 1 - std::pow(kBetaMean, static_cast<double>(steps));
  const double square_fill = std::sqrt(1 - std::pow(kBetaSquare, static_cast<double>(steps)));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (orthogonal_[i]) {
      mean[i].mul_(kMomentum).add_(gradients[i]);
      const torch::Tensor ahead = gradients[i].add(mean[i], kMomentum).flatten(1);
      const auto longest = static_cast<double>(std::max(ahead.size(0), ahead.size(1)));
      parameters[i].add_(orthogonalise(ahead).view_as(parameters[i]),
                         -learning_rate * kStepSize * std::sqrt(longest));
      continue;
    }
    mean[i].mul_(kBetaMean).add_(gradients[i], 1 - kBetaMean);
    square[i].mul_(kBetaSquare).addcmul_(gradients[i], gradients[i], 1 - kBetaSquare);
    const torch::Tensor divisor = square[i].sqrt().div_(square_fill).add_(kEpsilon);
    parameters[i].addcdiv_(mean[i], divisor, -learning_rate / mean_fill);
  }
}

std::vector<bool> matrices_of_backbones(const model::Architecture& architecture) {
  std::vector<bool> which;
  for (const model::TensorSpec& spec : model::network_tensors(architecture))
    which.push_back(spec.shape.size() == 4 || spec.name.ends_with("features.weight"));
  return which;
}

MovingAverage::MovingAverage(const Parameters& parameters) {
  for (const torch::Tensor& p : parameters) average.push_back(p.detach().clone());
}

void MovingAverage::add(const Parameters& parameters, double keep) {
  const at::NoGradGuard no_gradients;
  const auto n = static_cast<double>(++count);
  const double share = 1 - std::min(keep, (1 + n) / (10 + n));
  for (std::size_t i = 0; i < parameters.size(); ++i) average[i].lerp_(parameters[i].detach(), share);
}

}  // namespace mien::train
