#include "mien/study/interval.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace mien::study {
namespace {

struct Spread {
  double mean = 0;
  double of_mean = 0;  ///< Variance of the mean; 0 of one value.
};

Spread spread_of(std::span<const double> values) {
  Spread out;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) out.mean += v / n;
  if (values.size() < 2) return out;
  for (const double v : values) out.of_mean += (v - out.mean) * (v - out.mean) / (n - 1) / n;
  return out;
}

}  // namespace

double student_95(double degrees) {
  constexpr std::array kWhole = {12.7062, 4.3027, 3.1824, 2.7764, 2.5706,
                                 2.4469,  2.3646, 2.3060, 2.2622, 2.2281};
  constexpr double kNormal = 1.959964;
  const double at = std::max(1.0, degrees);
  if (at < static_cast<double>(kWhole.size())) {
    // Between whole degrees linear in 1 / degrees.
    const auto below = static_cast<std::size_t>(std::floor(at));
    const double low = 1 / static_cast<double>(below), high = 1 / static_cast<double>(below + 1);
    return kWhole[below - 1] + (low - 1 / at) / (low - high) * (kWhole[below] - kWhole[below - 1]);
  }
  // Abramowitz and Stegun, 26.7.5, three terms.
  const double z = kNormal, z2 = z * z;
  return z * (1 + (z2 + 1) / (4 * at) + ((5 * z2 + 16) * z2 + 3) / (96 * at * at) +
              (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * at * at * at));
}

Interval mean_interval(const SeedFigures& figures) {
  const std::size_t people = figures.front().size();
  std::vector<double> of_people(people, 0.0), of_seeds;
  for (const std::vector<double>& seed : figures) {
    double sum = 0;
    for (std::size_t p = 0; p < people; ++p) {
      of_people[p] += seed[p] / static_cast<double>(figures.size());
      sum += seed[p];
    }
    of_seeds.push_back(sum / static_cast<double>(people));
  }
  const Spread over_people = spread_of(of_people), over_seeds = spread_of(of_seeds);
  const double variance = over_people.of_mean + over_seeds.of_mean;
  if (!(variance > 0)) return {over_people.mean, over_people.mean, over_people.mean};
  // Welch and Satterthwaite.
  const auto part = [](double of_mean, std::size_t count) {
    return count < 2 ? 0.0 : of_mean * of_mean / static_cast<double>(count - 1);
  };
  const double degrees =
      variance * variance / (part(over_people.of_mean, people) + part(over_seeds.of_mean, figures.size()));
  const double half = student_95(degrees) * std::sqrt(variance);
  return {over_people.mean, over_people.mean - half, over_people.mean + half};
}

Interval change_interval(const SeedFigures& figures, const SeedFigures& base) {
  const double whole = mean_interval(base).mean, ratio = mean_interval(figures).mean / whole;
  SeedFigures residuals = figures;
  for (std::size_t s = 0; s < residuals.size(); ++s)
    for (std::size_t p = 0; p < residuals[s].size(); ++p)
      residuals[s][p] = (figures[s][p] - ratio * base[s][p]) / whole;
  const Interval of = mean_interval(residuals);  // About 0.
  return {ratio - 1, ratio - 1 + of.low, ratio - 1 + of.high};
}

}  // namespace mien::study
