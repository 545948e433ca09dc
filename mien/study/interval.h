#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace mien::study {

/// A mean, and where it lies with 95 % confidence.
struct Interval {
  double mean = 0;
  double low = 0;
  double high = 0;
};

/// Figures of one method: of each seed that it was trained with, one figure a person, the same people in the
/// same order. At least one seed and one person, and as many of each seed.
using SeedFigures = std::vector<std::vector<double>>;

/// The mean over seeds and people. Both vary: the variances of the mean over people and of the mean over
/// seeds add, and the degrees of freedom of Student's t follow by Welch and Satterthwaite (Satterthwaite
/// 1946, doi:10.2307/3002019). Of one seed the people's alone, of one person the seeds' alone; of one figure
/// the interval is the figure.
[[nodiscard]] Interval mean_interval(const SeedFigures& figures);

/// How much larger `figures` are than `base`, as a share of base's mean: 0.04 is 4 % more. Paired by person
/// and seed, so that what both share cancels: the ratio of the means, and its interval by the residuals about
/// it (the ratio estimator's linearisation; Cochran 1977, Sampling Techniques, 6.3). Same shapes; base's mean
/// above 0.
[[nodiscard]] Interval change_interval(const SeedFigures& figures, const SeedFigures& base);

/// Two-sided 95 % quantile of Student's t at these degrees of freedom, 1 or more.
[[nodiscard]] double student_95(double degrees);

}  // namespace mien::study
