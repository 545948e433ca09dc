#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/eyewear/marker_poses.h"

namespace mien::lab {

/// The kinds of test expressions of Asano et al. 2017, section 5.1: neutral, (A) poses of the six components,
/// (B) the six universal expressions, (C) asymmetric ones.
enum class SensorsTestSet : std::uint8_t { neutral, components, universal, asymmetric };
inline constexpr std::size_t kTestSets = 4;
/// "neutral", "A", "B", "C".
[[nodiscard]] std::string_view sensors_test_set_name(SensorsTestSet set);

/// One expression that a wearer is to make.
struct SensorsTest {
  SensorsTestSet set = SensorsTestSet::neutral;
  face::BlendshapeWeights target;
};
inline constexpr std::size_t kTests = 19;

/// The tests in the order in which they are made: kTests of them. Components' poses are drawn.
[[nodiscard]] std::vector<SensorsTest> make_sensors_tests(const virt::MarkerPoses& poses, Random random);

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

/// Between training and tests, s.
inline constexpr double kRestS = 60;

/// The protocol of Asano et al. 2017, section 5.1; the defaults are the paper's.
struct SensorsRequest {
  int wearers = 3;
  int poses = 600;             ///< Target poses of the training, of six components.
  double pose_s = 3;           ///< Each is on the screen for this long.
  std::size_t samples = 5000;  ///< Drawn from the training.
  double test_s = 10;          ///< Each of the nineteen tests.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// One wearer's training.
struct SensorsTraining {
  std::size_t samples = 0;
  std::size_t outliers = 0;  ///< Rejected of these, beyond four standard deviations.
  double share = 0;          ///< Of the markers' variance, that 20 components hold.
};

struct SensorsStudy {
  std::vector<std::string> markers;  ///< Names.
  std::vector<SensorsTraining> training;
  SensorsMethod faithful;    ///< All sensors.
  SensorsMethod faithful16;  ///< Without those on the ear hooks.
  SensorsMethod mean_pose;   ///< The training's mean: knowing nothing.
};

/// Sensors on the ear hooks, by their sites "jaw_joint" and "lower_jaw".
[[nodiscard]] std::vector<std::uint16_t> ear_hook_sensors(const sensor::Rig& rig);

/// Each wearer puts the glasses on once, follows the target poses while sensors and motion capture record,
/// and then makes the tests with the glasses still on. The published method is fitted to what was captured,
/// and measured against where the markers truly are. Wearers are virtual ones of the built-in family; faults
/// are the rig's. The same request gives the same numbers, whatever the number of threads. Errors: those of
/// rig, faults and fit; bad_usage (fewer than one wearer, pose or the samples that a fit needs); cancelled.
/// Cost: about a minute of one core a wearer.
[[nodiscard]] Result<SensorsStudy> study_sensors(const SensorsRequest& request, const sensor::Rig& rig,
                                                 const builtin_face::MarkerSet& markers,
                                                 const Progress& progress);

}  // namespace mien::lab
