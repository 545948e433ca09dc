#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/imu/level_shift.h"
#include "mien/imu/nod_watch.h"
#include "mien/imu/walk_scale.h"
#include "mien/sensor/rig.h"

namespace mien::imu {

/// Settings of the drift filter. Chosen on virtual performers of seeds 101 to 107
/// (docs/experiments/hours.md). "Weigh less": the Kalman gain of that measurement falls, so drift is
/// corrected later and the states are steadier.
struct DriftSettings {
  // Process noise.
  /// Random walk of one heading, and of all headings together (the ear sensor's own), rad a root s (0.11 and
  /// 0.06 deg). Raising: headings are corrected sooner, held expressions that turn about the vertical fade
  /// sooner. Lowering: drift is corrected later.
  double heading_walk = 2e-3;
  double common_walk = 1e-3;
  /// Random walk of a heading's rate, rad/s a root s: two gyroscopes' biases, each 0.05 deg/s a root minute.
  /// Where gyroscopes drift faster the filter finds it (WalkScale). Raising: changes of the rate are followed
  /// sooner. Lowering: a steadier rate.
  double rate_walk = 1.6e-4;
  /// Standard deviation of that rate after a calibration, rad/s (0.09 deg/s). Raising: the rate is found
  /// sooner, the heading is less certain meanwhile. Lowering: it is found later.
  double rate_sigma_rad_s = 1.5e-3;
  /// Random walk of an adhesive's creep, rad a root s and axis (0.5 deg a root minute, as of the rig's
  /// faults); the ear sensor's too. Where the adhesives creep faster the filter finds it (WalkScale).
  /// Raising: creep is followed sooner, held expressions fade into neutral. Lowering: creep remains; 0: none
  /// is tracked.
  double creep_walk = 1.13e-3;

  // Measurement by the wearer's distribution.
  /// Correlation time of the skin's deviation from its mean, s: one independent measurement in this time.
  /// Expressions last for seconds, and what a performer does for minutes. Raising: measurements weigh less,
  /// held expressions stay for longer. Lowering: drift is held tighter. After gaps it is shorter for a while.
  double correlation_s = 60;
  /// The same right after a calibration, from where it grows by a fifth of the time that has passed: a mean
  /// of few seconds is learnt along. Raising: the first minutes' headings are less certain. Lowering: they
  /// are held tighter, and what a performer does first fades.
  double first_correlation_s = 10;
  /// Innovation gate along one direction of the distribution, standard deviations. Raising: unusual
  /// expressions pull at the states. Lowering: large drift is corrected later.
  double gate = 2.5;
  /// Least standard deviation along a direction, rad (0.3 deg): noise, adhesive lag, linearisation. Raising:
  /// measurements of still skin weigh less. Lowering: they weigh more.
  double least_sigma_rad = 0.0052;

  // Learning the wearer's distribution.
  /// How long after a calibration the mean of the wearer's skin rotation is learnt, s; it is kept then.
  /// Raising: a mean of more that the wearer does, and of more creep. Lowering: of the first minute alone.
  double mean_s = 600;
  /// How many seconds of the wearer the rig's `[skin]` table counts for in the covariance, s. Raising: it is
  /// learnt more slowly. Lowering: the first seconds count for more.
  double people_s = 60;
  /// Memory of the covariance, s. Raising: what a wearer does is forgotten later. Lowering: the covariance
  /// follows what he does now.
  double memory_s = 1200;
  /// A sensor that is absent for longer than this, s, while at least half of all are present, may have been
  /// taken off and put on again: its creep is then uncertain by `put_on_rad` an axis (15 deg). Raising the
  /// time: batteries may be changed for longer. Lowering it, or raising the angle: a sensor that sits
  /// elsewhere is found sooner, one that only was silent forgets its creep.
  double taken_off_s = 30;
  double put_on_rad = 0.26;
  /// Expressions that are held: what they add to the skin's rotation is not taken for drift.
  LevelShiftSettings shift;
};

/// One Kalman filter of everything that drifts between the sensors of a face after a calibration. States: for
/// each face sensor heading error, its rate, and the creep of its adhesive (rotation vector, frame H); and
/// the creep of the ear sensor's adhesive, which turns all face sensors' rotations alike. Measurements: nods
/// (NodWatch), and the skin itself: rotation vectors of all sensors, less the mean that the wearer's skin had
/// in the first minutes, scatter by the wearer's own covariance, which begins as people's (the rig's `[skin]`
/// table). Directions in which this skin hardly ever moves show drift at once, those in which it moves
/// strongly only slowly; beyond a gate a deviation is an expression. Error model, formulas and what it cannot
/// tell: docs/method/fusion.md. Thread: one at a time. No allocation after construction. Cost: about 15 us a
/// frame with eleven sensors, more where the directions are computed anew (every 10 to 300 s, and when
/// sensors come and go).
class DriftFilter {
 public:
  /// `face_sensors`: names, in the order of all numbers below. `skin`: how people's skin turns; sensors that
  /// it lacks, all where it is none, get a broad prior (10 degrees an axis, uncorrelated).
  DriftFilter(const DriftSettings& settings, const std::optional<sensor::SkinMotion>& skin,
              std::span<const std::string> face_sensors);

  /// After a calibration: no creep, the wearer unknown. Headings follow by move_to().
  void start();
  /// Sets the heading of a sensor, Z_i's angle, and its standard deviation, rad; the rate becomes unknown.
  /// What was estimated of creep and wearer is kept.
  void move_to(std::size_t sensor, double heading_rad, double sigma_rad);
  /// Adds the heading uncertainty of a gap, one standard deviation, rad; for some seconds the skin then
  /// weighs more.
  void inflate(std::size_t sensor, double sigma_rad);
  /// The ear sensor's own heading has changed by this, and is uncertain by this, rad: all headings together.
  void turn_all(double by_rad, double sigma_rad);
  /// One frame later.
  void predict(double dt_s);
  void add_nod(std::size_t sensor, const NodMeasurement& nod);
  /// The face's rotations at one frame, `dt_s` after the last one. Shape: an entry a face sensor. `turn_rad`:
  /// E_i by the present states as rotation vectors, frame H, rad; none where it is missing. `tilt_rad2`:
  /// variance of each sensor's tilt after gaps. `up`: the vertical, unit, frame H.
  void add_skin(double dt_s, std::span<const std::optional<Vec3>> turn_rad, std::span<const double> tilt_rad2,
                const Vec3& up);

  /// The face at rest, as at the calibration: E_i is the identity but for what drifts. Shape: an entry a face
  /// sensor. `turn_rad`: the mean of E_i over the rest by the present states, frame H, rad; none where it was
  /// not measured. `sigma_rad`: how far a resting face and the measurement are from neutral, an axis. `up`:
  /// as of add_skin(), mean. A person has asked for it, so that no prior outweighs it: where a rotation is
  /// beyond what the states allow, as of a sensor that was put on again, they are made as uncertain as it is
  /// large. Allocates.
  void observe_rest(std::span<const std::optional<Vec3>> turn_rad, std::span<const double> sigma_rad,
                    const Vec3& up);

  /// Z_i's angle now, (-pi, pi], and its standard deviation, at most pi.
  [[nodiscard]] double heading_rad(std::size_t sensor) const { return heading_rad_[sensor]; }
  [[nodiscard]] double heading_sigma_rad(std::size_t sensor) const;
  /// Creep since start(): rotation vector, frame H, rad. E_i = exp(ear creep) C P_i N_i^T C^T exp(-creep).
  [[nodiscard]] const Vec3& creep_rad(std::size_t sensor) const { return creep_rad_[sensor]; }
  [[nodiscard]] const Vec3& ear_creep_rad() const { return ear_creep_rad_; }
  /// Covariance of the error of E_i that headings, creep and the mean of the wearer's skin leave, frame H,
  /// rad^2. `up`: as of add_skin().
  [[nodiscard]] Mat3 rotation_covariance(std::size_t sensor, const Vec3& up) const;
  /// Whether the covariance is one (is_covariance()).
  [[nodiscard]] bool sound() const;
  /// How often the covariance was none, and the filter began anew: a defect of this program.
  [[nodiscard]] std::uint64_t faults() const { return faults_; }

 private:
  using Index = Eigen::Index;
  /// First states: headings, rates, creep, the ear sensor's creep.
  [[nodiscard]] Index rate(std::size_t sensor) const { return static_cast<Index>(count_ + sensor); }
  [[nodiscard]] Index creep(std::size_t sensor) const { return static_cast<Index>(2 * count_ + 3 * sensor); }
  [[nodiscard]] Index ear() const { return static_cast<Index>(5 * count_); }
  /// Kalman update by the scalar measurement `observation_` x + noise.
  void correct(double innovation_rad, double noise_rad2);
  /// Sensors that have been absent for long may sit elsewhere.
  void follow_presence(double dt_s);
  /// Takes the present rotations into the wearer's mean and covariance; their deviations from the mean.
  void learn(double dt_s);
  /// Directions of the wearer's distribution over the sensors that are present.
  void find_directions();
  void observe(Index direction, const Vec3& up);
  /// The present frame's measurement along one direction. `strength2`: how strongly the face moves, squared.
  void measure(Index direction, double strength2, std::span<const double> tilt_rad2, const Vec3& up);
  /// A sensor's part in observe_rest(), with the states before it.
  struct Resting {
    std::size_t sensor;
    double sigma_rad;
    Quat turn;
    double heading_rad;
    Quat creep;
  };
  /// Sets `observation_` for one axis of E_i, which is `turn_rad` now.
  void observe_axis(std::size_t sensor, Index axis, const Vec3& turn_rad, const Vec3& up);
  /// Where most sensors are off alike the ear sensor has moved: its creep is corrected by their median.
  void correct_ear_by_rest(std::span<const Vec3> turn_rad, std::span<const Resting> resting, const Vec3& up);
  /// Sensor and wearer's distribution after the sensor was found to sit elsewhere by `turn_rad`.
  void expect_moved(std::size_t sensor, const Vec3& turn_rad, const Vec3& up);
  /// What headings and creep leave of E_i, as rotation_covariance() has it.
  [[nodiscard]] Mat3 states_covariance(std::size_t sensor, const Vec3& up) const;
  /// Scales the process noise of rates and creep (WalkScale).
  void follow_walks(double dt_s);
  void check();

  DriftSettings settings_;
  std::size_t count_;
  std::vector<double> heading_rad_, rate_rad_s_;
  std::vector<Vec3> creep_rad_;
  Vec3 ear_creep_rad_ = Vec3::Zero();
  Eigen::MatrixXd covariance_;
  std::uint64_t faults_ = 0;
  WalkScale rate_scale_, creep_scale_;

  Eigen::MatrixXd people_rad2_;  // Second moment of people's rotation vectors about neutral.
  Eigen::MatrixXd wearer_rad2_;  // The wearer's about their mean.
  Eigen::VectorXd mean_rad_;
  std::vector<double>
      observed_s_;                // By sensor: how long it has been present since start(), or since it moved.
  std::vector<double> absent_s_;  // By sensor: how long it has not been, while half of all were.
  std::vector<double> gaps_rad2_s_;  // By sensor: what gaps have lately added to its heading's variance, a s.
  double since_start_s_ = 0;

  std::vector<bool> present_, directed_;  // Sensors now, and those of the directions.
  std::vector<double> differs_s_;         // By sensor: how long they have differed.
  double directions_s_ = 0;               // Age of the directions.
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> directions_;
  std::vector<double> waited_s_;  // By direction, since its last measurement.
  std::size_t next_ = 0;
  LevelShift level_;

  // Of the present frame; members, so that nothing is allocated.
  Eigen::MatrixXd distribution_rad2_;
  Eigen::VectorXd deviation_rad_, along_rad_, observation_, spread_, changed_;
  std::vector<Vec3> turn_rad_;
};

}  // namespace mien::imu
