#include "mien/measure/interval.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace mien::measure {
namespace {

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// Times `each`, the figures that each of the means is of: the mean square of a factor.
double mean_square(std::span<const double> means, double mean, double each) {
  double sum = 0;
  for (const double m : means) sum += (m - mean) * (m - mean);
  return means.size() < 2 ? 0 : each * sum / static_cast<double>(means.size() - 1);
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
  const std::size_t people = figures.front().size(), seeds = figures.size();
  std::vector<double> of_people(people, 0.0), of_seeds;
  for (const std::vector<double>& seed : figures) {
    of_seeds.push_back(mean_of(seed));
    for (std::size_t p = 0; p < people; ++p) of_people[p] += seed[p] / static_cast<double>(seeds);
  }
  const double mean = mean_of(of_seeds);
  double residual = 0;
  for (std::size_t s = 0; s < seeds; ++s)
    for (std::size_t p = 0; p < people; ++p) {
      const double one = figures[s][p] - of_seeds[s] - of_people[p] + mean;
      residual += one * one;
    }
  struct MeanSquare {
    double value;
    double degrees;
  };
  const double people_degrees = static_cast<double>(people) - 1,
               seed_degrees = static_cast<double>(seeds) - 1;
  const MeanSquare person{mean_square(of_people, mean, static_cast<double>(seeds)), people_degrees};
  const MeanSquare seed{mean_square(of_seeds, mean, static_cast<double>(people)), seed_degrees};
  const MeanSquare both{people_degrees * seed_degrees > 0 ? residual / (people_degrees * seed_degrees) : 0,
                        people_degrees * seed_degrees};
  const MeanSquare& larger = person.value > seed.value ? person : seed;
  double square = person.value + seed.value - both.value, degrees = 0;
  if (square > larger.value) {
    double sum = 0;
    for (const MeanSquare& one : {person, seed, both})
      if (one.degrees > 0) sum += one.value * one.value / one.degrees;
    degrees = square * square / sum;
  } else {
    square = larger.value;
    degrees = larger.degrees;
  }
  if (!(square > 0)) return {mean, mean, mean};
  const double half = student_95(degrees) * std::sqrt(square / static_cast<double>(people * seeds));
  return {mean, mean - half, mean + half};
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

}  // namespace mien::measure
