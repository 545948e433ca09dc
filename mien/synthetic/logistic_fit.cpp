#include "mien/synthetic/logistic_fit.h"

#include <algorithm>
#include <cmath>

#include "mien/core/logistic.h"

namespace mien::synthetic {
namespace {

constexpr int kMostSteps = 100;
constexpr int kMostHalvings = 40;
constexpr double kConverged = 1e-10;
constexpr double kPrecision = 1 / (LogisticFit::kPriorSigma * LogisticFit::kPriorSigma);

/// ln(1 + exp(x)) without overflow.
double softplus(double x) {
  return x > 0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x));
}

}  // namespace

void LogisticFit::add(float score, bool hit, double times) {
  const float held = std::clamp(score, -kLimit, kLimit);
  const auto place = static_cast<std::size_t>((held + kLimit) / (2 * kLimit) * static_cast<float>(kBins));
  Bin& bin = bins_[std::min(place, kBins - 1)];
  bin.frames += times;
  bin.hits += hit ? times : 0;
  bin.score += times * double{held};
}

void LogisticFit::add(const LogisticFit& other) {
  for (std::size_t b = 0; b < kBins; ++b) {
    bins_[b].frames += other.bins_[b].frames;
    bins_[b].hits += other.bins_[b].hits;
    bins_[b].score += other.bins_[b].score;
  }
}

double LogisticFit::frames() const {
  double sum = 0;
  for (const Bin& bin : bins_) sum += bin.frames;
  return sum;
}

double LogisticFit::log_likelihood(double offset, double slope) const {
  double sum = -0.5 * kPrecision * (offset * offset + slope * slope);
  for (const Bin& bin : bins_) {
    if (bin.frames == 0) continue;
    const double log_odds = offset + slope * bin.score / bin.frames;
    sum -= bin.hits * softplus(-log_odds) + (bin.frames - bin.hits) * softplus(log_odds);
  }
  return sum;
}

model::LogisticMap LogisticFit::solve() const {
  double offset = 0, slope = 0, likelihood = log_likelihood(0, 0);
  for (int step = 0; step < kMostSteps; ++step) {
    // Gradient, and the negative Hessian, whose prior keeps it positive definite.
    double g0 = -kPrecision * offset, g1 = -kPrecision * slope;
    double h00 = kPrecision, h01 = 0, h11 = kPrecision;
    for (const Bin& bin : bins_) {
      if (bin.frames == 0) continue;
      const double x = bin.score / bin.frames;
      const double p = logistic(offset + slope * x);
      const double missed = bin.hits - bin.frames * p, weight = bin.frames * p * (1 - p);
      g0 += missed;
      g1 += missed * x;
      h00 += weight;
      h01 += weight * x;
      h11 += weight * x * x;
    }
    const double determinant = h00 * h11 - h01 * h01;
    double d0 = (h11 * g0 - h01 * g1) / determinant, d1 = (h00 * g1 - h01 * g0) / determinant;
    int halvings = 0;
    double reached = log_likelihood(offset + d0, slope + d1);
    // Written so that a likelihood that is no number counts as a fall.
    for (; halvings < kMostHalvings && !(reached >= likelihood); ++halvings) {
      d0 /= 2;
      d1 /= 2;
      reached = log_likelihood(offset + d0, slope + d1);
    }
    if (halvings == kMostHalvings) break;
    offset += d0;
    slope += d1;
    likelihood = reached;
    if (std::abs(d0) + std::abs(d1) < kConverged) break;
  }
  return {static_cast<float>(offset), static_cast<float>(slope)};
}

}  // namespace mien::synthetic
