#include "mien/train/optimiser.h"

#include <algorithm>
#include <cmath>

namespace mien::train {
namespace {

constexpr double kBetaMean = 0.9, kBetaSquare = 0.999, kEpsilon = 1e-8;

}  // namespace

Adam::Adam(const Parameters& parameters) {
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
    mean[i].mul_(kBetaMean).add_(gradients[i], 1 - kBetaMean);
    square[i].mul_(kBetaSquare).addcmul_(gradients[i], gradients[i], 1 - kBetaSquare);
    const torch::Tensor divisor = square[i].sqrt().div_(square_fill).add_(kEpsilon);
    parameters[i].addcdiv_(mean[i], divisor, -learning_rate / mean_fill);
  }
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
