#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lab/motion_rhythm.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/motion.h"
#include "mien/measure/report.h"

namespace mien::lab {

/// How one shape is used.
struct ShapeStatistics {
  double mean = 0;
  double deviation = 0;    ///< Standard deviation over frames.
  double rest = 0;         ///< 10th percentile: where the shape comes back to.
  double p95 = 0;          ///< 95th percentile.
  double speed_per_s = 0;  ///< Root mean square of the derivative.
};

/// How a face moves: range, speed, rest, rhythm, and what moves together. Frames without a face are left out.
struct MotionStatistics : MotionRhythm {
  std::string name;
  double duration_s = 0;  ///< Of what was counted.
  std::array<ShapeStatistics, face::kShapeCount> shapes{};
  /// Pearson's, of all pairs of shapes; 0 where a shape does not move.
  Eigen::MatrixXd correlation;  // kShapeCount x kShapeCount

  double mean_weight = 0;  ///< Means over the shapes.
  double mean_deviation = 0;
  double mean_rest = 0;
  double mean_p95 = 0;
  double mean_speed_per_s = 0;
  /// Root mean square speed over deviation, of the median shape, 1/s: how quick motion is for its size.
  double quickness_per_s = 0;
  double active_shapes = 0;         ///< Mean number of weights above 0.1.
  double mean_abs_correlation = 0;  ///< Of all pairs but left with right of one shape.
  double side_correlation = 0;      ///< Mean of left with right.
  /// Participation ratio of the covariance, (sum of eigenvalues)^2 / sum of their squares: about how many
  /// independent motions there are.
  double dimensions = 0;
};

/// One summary: what it is called in JSON and for people, and how many digits these need.
struct MotionSummary {
  std::string_view name;
  std::string_view label;
  double MotionStatistics::*value;
  int digits;
};
inline constexpr std::array kMotionSummaries = {
    MotionSummary{"seconds", "seconds", &MotionStatistics::duration_s, 0},
    MotionSummary{"mean_weight", "mean weight", &MotionStatistics::mean_weight, 3},
    MotionSummary{"deviation", "standard deviation, mean of shapes", &MotionStatistics::mean_deviation, 3},
    MotionSummary{"rest", "rest (10th percentile)", &MotionStatistics::mean_rest, 3},
    MotionSummary{"p95", "95th percentile", &MotionStatistics::mean_p95, 3},
    MotionSummary{"speed_per_s", "speed, RMS, 1/s", &MotionStatistics::mean_speed_per_s, 2},
    MotionSummary{"quickness_per_s", "speed over deviation, median shape, 1/s",
                  &MotionStatistics::quickness_per_s, 2},
    MotionSummary{"active_shapes", "shapes above 0.1", &MotionStatistics::active_shapes, 1},
    MotionSummary{"side_correlation", "correlation of left with right", &MotionStatistics::side_correlation,
                  2},
    MotionSummary{"pair_correlation", "absolute correlation of other pairs",
                  &MotionStatistics::mean_abs_correlation, 2},
    MotionSummary{"dimensions", "independent motions (participation ratio)", &MotionStatistics::dimensions,
                  1},
    MotionSummary{"rest_share", "share of time at rest, mean of shapes", &MotionStatistics::rest_share, 2},
    MotionSummary{"still_share", "share of time with the whole face at rest", &MotionStatistics::still_share,
                  2},
    MotionSummary{"speed_tail", "99th percentile of speed over its RMS", &MotionStatistics::speed_tail, 2},
    MotionSummary{"slowest", "variance: changes over 4 s", &MotionStatistics::slowest, 2},
    MotionSummary{"slow", "variance: 1 to 4 s", &MotionStatistics::slow, 2},
    MotionSummary{"quick", "variance: 0.25 to 1 s", &MotionStatistics::quick, 2},
    MotionSummary{"quickest", "variance: under 0.25 s", &MotionStatistics::quickest, 2},
    MotionSummary{"expression_s", "expressions last, median, s", &MotionStatistics::expression_s, 2},
    MotionSummary{"long_expression_s", "expressions last, 90th percentile, s",
                  &MotionStatistics::long_expression_s, 2},
    MotionSummary{"blinks_per_min", "blinks a minute", &MotionStatistics::blinks_per_min, 1},
    MotionSummary{"blink_s", "a blink lasts, at half height, s", &MotionStatistics::blink_s, 2},
    MotionSummary{"blink_closing_share", "of it closing", &MotionStatistics::blink_closing_share, 2},
    MotionSummary{"blink_peak", "eyeBlink at a blink's peak", &MotionStatistics::blink_peak, 2},
    MotionSummary{"blink_side_difference", "left from right then", &MotionStatistics::blink_side_difference,
                  2}};

/// Statistics of one or more motions taken together, each read at 30 Hz through its own curve, so that
/// recordings of 30 and 60 frames a second compare. Needs at least two frames with a face; else all is 0.
[[nodiscard]] MotionStatistics motion_statistics(std::span<const face::Motion> motions, std::string name);

/// The mean of several people's statistics, each weighing the same: what one person of them is like. (Taking
/// their frames together would count the differences between people as motion.)
[[nodiscard]] MotionStatistics mean_statistics(std::span<const MotionStatistics> people, std::string name);

/// Pearson correlation of the two correlation matrices' entries above the diagonal, -1 to 1: do the same
/// shapes go together?
[[nodiscard]] double correlation_agreement(const MotionStatistics& a, const MotionStatistics& b);

/// One number about a motion: a summary ("blinks_per_min"), how two groups of shapes go together ("brows with
/// mouth": mean absolute correlation of their shapes, sides of one shape left out), or a shape's ("mean of
/// jawOpen").
struct MotionValue {
  std::string name;
  double value = 0;
};
/// All of a motion's numbers but its length, always in the same order.
[[nodiscard]] std::vector<MotionValue> motion_values(const MotionStatistics& motion);

/// Where a motion lies among people: 5th, 50th and 95th percentile of one number over people.
struct MotionSpread {
  std::string name;
  double low = 0, median = 0, high = 0;
  std::vector<double> compared;  ///< The same number of each motion that is compared, in their order.
  [[nodiscard]] bool holds(std::size_t i) const { return compared[i] >= low && compared[i] <= high; }
};
/// In motion_values' order; `people`: at least one.
[[nodiscard]] std::vector<MotionSpread> motion_spreads(std::span<const MotionStatistics> people,
                                                       std::span<const MotionStatistics> compared);

struct VirtualMotionRequest {
  int performers = 20;   ///< People drawn, each of whom performs every kind of script.
  double seconds = 120;  ///< Of each performance.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// People who perform one kind of script.
struct VirtualKind {
  std::string name;                      ///< As performer::block_name, or "training".
  std::vector<MotionStatistics> people;  ///< Each one's own.
};

/// How virtual performers move: for each kind of script from range of motion to acted lines, and last for the
/// random scripts of trainings ("training"). The same request gives the same numbers, whatever the number of
/// threads. Errors: bad_usage (nobody, or less than a second); cancelled. Cost: a hundredth of what is
/// performed.
[[nodiscard]] Result<std::vector<VirtualKind>> virtual_motion(const VirtualMotionRequest& request,
                                                              const Progress& progress);

/// Two tables of one column a motion: the summaries, with the agreement of correlations with each of the
/// first `compared` columns; then the standard deviation of every shape.
[[nodiscard]] std::vector<measure::Table> motion_tables(std::span<const MotionStatistics> columns,
                                                        std::size_t compared = 0);

/// What of the compared motions lies outside of the spread of people: one row a number, those that are
/// outside for most motions first. `names`: of the compared motions.
[[nodiscard]] measure::Table spread_table(std::span<const MotionSpread> spreads,
                                          std::span<const std::string> names);

}  // namespace mien::lab
