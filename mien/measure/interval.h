#pragma once

#include <vector>

namespace mien::measure {

/// A mean, and where it lies with 95 % confidence.
struct Interval {
  double mean = 0;
  double low = 0;
  double high = 0;

  /// Half of its width. 0: nothing tells it, as of one figure.
  [[nodiscard]] double half() const { return 0.5 * (high - low); }
};

/// Figures of one method: of each seed that it was trained with, one figure a person, the same people in the
/// same order. At least one seed and one person, and as many of each seed.
using SeedFigures = std::vector<std::vector<double>>;

/// The mean over seeds and people, both drawn at random and crossed: the variance of the mean is (MS_people +
/// MS_seeds - MS_residual) / count by the mean squares of the two-way analysis of variance without
/// replication (the residual, their interaction, is in both of the others), at least the larger of the two
/// over count; the degrees of freedom of Student's t follow by Satterthwaite (1946, doi:10.2307/3002019). Of
/// one seed the people's variance alone, of one person the seeds'; of one figure the interval is the figure.
[[nodiscard]] Interval mean_interval(const SeedFigures& figures);

/// How much larger `figures` are than `base`, as a share of base's mean: 0.04 is 4 % more. Paired by person
/// and seed, so that what both share cancels: the ratio of the means, and its interval by the residuals about
/// it (the ratio estimator's linearisation; Cochran 1977, Sampling Techniques, 6.3). Same shapes; base's mean
/// above 0.
[[nodiscard]] Interval change_interval(const SeedFigures& figures, const SeedFigures& base);

/// Two-sided 95 % quantile of Student's t at these degrees of freedom, 1 or more.
[[nodiscard]] double student_95(double degrees);

}  // namespace mien::measure
