#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lab/eyewear/sensors_tests.h"
#include "mien/builtin_face/markers.h"

namespace mien::lab {

/// How far estimated markers are from where they truly are. The paper says "root mean squared error for each
/// marker" and gives averages: both readings are here.
struct MarkerError {
  double mean_mm = 0;  ///< Mean distance.
  double rmse_mm = 0;  ///< Root mean square distance, of each marker; their mean where several are meant.
};

/// What one method gave over some markers, tests and wearers.
struct SensorsRow {
  MarkerError all;
  MarkerError eyes_nose;
  MarkerError mouth;
};

/// A method on all wearers.
struct SensorsMethod {
  std::string name;  ///< "faithful", "faithful16", "mean_pose", "learned".
  std::size_t sensors = 0;
  SensorsRow overall;
  std::vector<SensorsRow> wearers;
  std::array<SensorsRow, kTestSets> sets;
  std::vector<SensorsRow> tests;     ///< kTests of them.
  std::vector<MarkerError> markers;  ///< In the set's order.
};

/// Sums over one wearer's samples of one test.
class MarkerSums {
 public:
  /// One sample: 3V each, metres.
  void add(const Eigen::VectorXd& estimate_m, const Eigen::VectorXd& truth_m);
  /// A row a sample.
  void add(const Eigen::MatrixXd& estimate_m, const Eigen::MatrixXd& truth_m);
  MarkerSums& operator+=(const MarkerSums& more);
  /// Over these markers.
  [[nodiscard]] MarkerError over(const std::vector<std::size_t>& markers) const;

 private:
  std::size_t samples_ = 0;
  Eigen::ArrayXd distance_mm_;  // A marker.
  Eigen::ArrayXd square_mm2_;
};

/// One method's sums: of each wearer, kTests of them. `tests` tells which set each is of.
[[nodiscard]] SensorsMethod sum_up(std::string name, std::size_t sensors,
                                   const std::vector<std::vector<MarkerSums>>& wearers,
                                   const std::vector<SensorsTest>& tests,
                                   const builtin_face::MarkerSet& markers);

}  // namespace mien::lab
