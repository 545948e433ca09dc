#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lab/imu/hours_study.h"

namespace mien::lab {

/// Limits of the ratio that the study judges by: for nine runs of ten, and for all.
inline constexpr double kRatioOfMost = 1.3, kRatioOfAll = 1.6;

/// Runs of one kind together: figures of a piece are means over the runs.
struct HoursSummary {
  std::string script, scenario;
  std::size_t runs = 0;
  HoursErrors first_mse, last_mse;  ///< Of the first and of the last ten minutes.
  double worst_ratio = 0;           ///< Largest of any run's pieces.
  double within_most = 0;           ///< Share of the runs all of whose ratios are at most kRatioOfMost.
  double within_all = 0;            ///< The same of kRatioOfAll.
  double first_rotation_deg = 0;
  double worst_rotation_deg = 0;         ///< Largest mean of any ten minutes.
  double least_nees = 0, most_nees = 0;  ///< Range of the means of each ten minutes.
  double first_missing = 0;              ///< Share of rotations, 0 to 1.
  double worst_missing = 0;              ///< Largest of any run's pieces.
  double worst_bias = 0;                 ///< Largest that grew in any run.
  std::size_t worst_shape = 0;           ///< Of that.
  /// Of the sensor to which something happens, ten minutes later, and in *frozen*: root mean square.
  double sensor_deg = 0, frozen_sensor_deg = 0;
};

/// A summary of each script in each scenario, in the order in which they first appear.
[[nodiscard]] std::vector<HoursSummary> summarise(std::span<const HoursRun> runs);

/// Share of the runs whose every piece's ratio is at most `limit`.
[[nodiscard]] double share_within(std::span<const HoursRun> runs, double limit);

}  // namespace mien::lab
