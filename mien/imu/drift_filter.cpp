#include "mien/imu/drift_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mien/core/covariance.h"
#include "mien/core/units.h"
#include "mien/imu/heading.h"

namespace mien::imu {
namespace {

/// What any sensor's skin does beside people's table, and what it does where that does not know the sensor:
/// standard deviations an axis, rad.
constexpr double kOffRad = 0.7 * kRadPerDeg, kUnknownRad = 10 * kRadPerDeg;
/// How strongly the face moves against its usual, by all directions: bounds; one direction counts for three
/// standard deviations at most.
constexpr double kLeastStrength = 0.15, kMostStrength = 4, kMostOfOne2 = 9;
/// Directions are computed anew after half of what has been learnt, within these, s; and once a sensor has
/// been absent, or is back, for so long, s: bursts of lost packets are shorter.
constexpr double kSoonest_s = 10, kLatest_s = 300, kGoneAfter_s = 0.5, kBackAfter_s = 0.15;
/// A direction with more than this share of its square at absent sensors is not measured.
constexpr double kMostAbsent = 0.3;
/// The wearer's mean counts from nothing to its share in about this time, s.
constexpr double kFirstMean_s = 10;
/// The correlation time grows by this share of the time since the calibration.
constexpr double kCorrelationGrowth = 0.2;
/// Gaps: what they add to the headings' variance is averaged over this time, s. The correlation time is at
/// most this share of the time in which it adds up to the skin's variance, and at least this, s. Where this
/// share of the skin's variance has been added, a deviation beyond the gate is not ignored but weighs the
/// less the larger it is: what was missed has heavy tails. Chosen on packets lost in bursts
/// (docs/experiments/hours.md).
constexpr double kGapMemory_s = 10, kGapShare = 0.15, kGapCorrelation_s = 0.7, kSoftGateShare = 0.25;
/// A common turn this uncertain, rad (5 deg), is no expression.
constexpr double kTurnedRad = 0.087;
/// Beyond this a direction's states are lost rather than drifted, rad^2 (6 deg).
constexpr double kLostRad2 = 0.011;
/// A heading more uncertain than this is beyond the linearisation, rad^2 (40 deg): each look begins with the
/// rotations as the last one corrected them.
constexpr double kAnywhereRad2 = 0.5;
/// Directions that are measured a frame while a sensor is lost.
constexpr std::size_t kLooksAtLost = 4;
/// Corrections of rates and of creep are compared with their expectation within these, s, and are usually
/// these shares of it: with the rig's faults 0.10 to 0.33 and 0.28 to 0.54 (virtual performers of seeds 101
/// to 104, means of ten minutes).
constexpr double kRateWindow_s = 15, kCreepWindow_s = 60;
constexpr double kUsualRateRatio = 0.35, kUsualCreepRatio = 0.5;
/// A rate that is found to walk faster is made less certain up to so many of its first variances.
constexpr double kMostOfFirstRate2 = 16;
/// Variance that marks a missing sensor's axes among the directions, rad^2: above any face's.
constexpr double kMissingRad2 = 100;
/// A rest beyond this is what the states do not allow: normalised innovation squared of three axes (a chance
/// of one in a thousand).
constexpr double kRestGate2 = 16.3;
/// A rest is taken into the states in so many steps, each about the states after the last: rotations of 40
/// degrees are beyond one linearisation.
constexpr int kRestSteps = 8;
/// The heading of a sensor that sits elsewhere is off by this share of what is to be seen of it: its board
/// went on integrating while it was moved, so most of the turn is the skin's to creep.
constexpr double kHeadingShare = 0.5;
/// A median of fewer sensors does not tell the ear sensor from them.
constexpr std::size_t kLeastForEar = 3;

/// Standard deviation of a heading after a fault of the filter, rad (10 deg).
constexpr double kAnewSigmaRad = 0.17;

/// What a heading error of one radian adds to the rotation vector `turn_rad`: log(exp(e up) exp(r)) to the
/// first order of e and the second of r.
Vec3 turn_by_heading(const Vec3& turn_rad, const Vec3& up) {
  const Vec3 sideways = turn_rad.cross(up);
  return up - 0.5 * sideways + turn_rad.cross(sideways) / 12;
}

}  // namespace

DriftFilter::DriftFilter(const DriftSettings& settings, const std::optional<sensor::SkinMotion>& skin,
                         std::span<const std::string> face_sensors)
    : settings_(settings),
      count_(face_sensors.size()),
      heading_rad_(count_),
      rate_rad_s_(count_),
      creep_rad_(count_, Vec3::Zero()),
      rate_scale_(count_, kRateWindow_s, kUsualRateRatio),
      creep_scale_(count_, kCreepWindow_s, kUsualCreepRatio),
      observed_s_(count_),
      absent_s_(count_),
      gaps_rad2_s_(count_),
      present_(count_),
      directed_(count_),
      differs_s_(count_),
      waited_s_(3 * count_),
      level_(settings.shift, count_),
      turn_rad_(count_, Vec3::Zero()) {
  const auto size = static_cast<Index>(3 * count_), states = static_cast<Index>(5 * count_ + 3);
  covariance_ = Eigen::MatrixXd::Zero(states, states);
  deviation_rad_ = along_rad_ = mean_rad_ = Eigen::VectorXd::Zero(size);
  observation_ = spread_ = changed_ = Eigen::VectorXd::Zero(states);
  directions_ = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(size);

  Eigen::VectorXd mean_rad = Eigen::VectorXd::Zero(size);
  Eigen::VectorXd own_rad2 = Eigen::VectorXd::Constant(size, kUnknownRad * kUnknownRad);
  Eigen::MatrixXd muscles = Eigen::MatrixXd::Zero(size, skin ? skin->factor_deg.cols() : 0);
  for (std::size_t i = 0; skin && i < count_; ++i) {
    const auto found = std::ranges::find(skin->sensors, face_sensors[i]);
    if (found == skin->sensors.end()) continue;
    const auto at = static_cast<Index>(3 * i), from = static_cast<Index>(3 * (found - skin->sensors.begin()));
    mean_rad.segment<3>(at) = kRadPerDeg * skin->mean_deg.segment<3>(from);
    muscles.middleRows<3>(at) = kRadPerDeg * skin->factor_deg.middleRows<3>(from);
    own_rad2.segment<3>(at).setConstant(kOffRad * kOffRad);
  }
  people_rad2_ = muscles * muscles.transpose() + mean_rad * mean_rad.transpose();
  people_rad2_.diagonal() += own_rad2;
  wearer_rad2_ = distribution_rad2_ = people_rad2_;
  start();
}

void DriftFilter::start() {
  covariance_.setZero();
  wearer_rad2_ = people_rad2_;
  mean_rad_.setZero();
  std::ranges::fill(observed_s_, 0.0);
  std::ranges::fill(absent_s_, 0.0);
  std::ranges::fill(gaps_rad2_s_, 0.0);
  since_start_s_ = 0;
  next_ = 0;
  level_.start(people_rad2_);
  rate_scale_.start();
  creep_scale_.start();
  ear_creep_rad_.setZero();
  std::ranges::fill(creep_rad_, Vec3(Vec3::Zero()));
  directed_.assign(count_, false);
  directions_s_ = kLatest_s;
  for (std::size_t i = 0; i < count_; ++i) move_to(i, 0, std::numbers::pi);
}

void DriftFilter::move_to(std::size_t sensor, double heading_rad, double sigma_rad) {
  level_.interrupt();
  heading_rad_[sensor] = wrap_heading(heading_rad);
  rate_rad_s_[sensor] = 0;
  const auto heading = static_cast<Index>(sensor);
  for (const Index state : {heading, rate(sensor)}) {
    covariance_.row(state).setZero();
    covariance_.col(state).setZero();
  }
  covariance_(heading, heading) = sigma_rad * sigma_rad;
  covariance_(rate(sensor), rate(sensor)) = settings_.rate_sigma_rad_s * settings_.rate_sigma_rad_s;
}

void DriftFilter::inflate(std::size_t sensor, double sigma_rad) {
  const auto heading = static_cast<Index>(sensor);
  covariance_(heading, heading) += sigma_rad * sigma_rad;
  gaps_rad2_s_[sensor] += sigma_rad * sigma_rad / kGapMemory_s;
}

void DriftFilter::turn_all(double by_rad, double sigma_rad) {
  if (by_rad != 0 || sigma_rad > kTurnedRad) level_.interrupt();
  for (double& heading : heading_rad_) heading = wrap_heading(heading + by_rad);
  const auto n = static_cast<Index>(count_);
  covariance_.topLeftCorner(n, n).array() += sigma_rad * sigma_rad;
}

double DriftFilter::heading_sigma_rad(std::size_t sensor) const {
  const auto heading = static_cast<Index>(sensor);
  return std::min(std::numbers::pi, std::sqrt(std::max(0.0, covariance_(heading, heading))));
}

Mat3 DriftFilter::states_covariance(std::size_t sensor, const Vec3& up) const {
  // E_i's error is up e + (creep - ear's creep) to first order.
  const auto heading = static_cast<Index>(sensor);
  const Mat3 creeps = covariance_.block<3, 3>(creep(sensor), creep(sensor)) +
                      covariance_.block<3, 3>(ear(), ear()) - covariance_.block<3, 3>(creep(sensor), ear()) -
                      covariance_.block<3, 3>(ear(), creep(sensor));
  const Vec3 shared =
      covariance_.block<3, 1>(creep(sensor), heading) - covariance_.block<3, 1>(ear(), heading);
  return creeps + up * (covariance_(heading, heading) * up + shared).transpose() + shared * up.transpose();
}

Mat3 DriftFilter::rotation_covariance(std::size_t sensor, const Vec3& up) const {
  // The states come to rest about the mean of the wearer's skin as it is estimated, of so many independent
  // looks.
  const auto at = static_cast<Index>(3 * sensor);
  const double share = std::min(1.0, observed_s_[sensor] / settings_.mean_s);
  const double looks = std::max(1.0, settings_.mean_s / settings_.correlation_s);
  return states_covariance(sensor, up) + share / looks * wearer_rad2_.block<3, 3>(at, at);
}

bool DriftFilter::sound() const {
  return is_covariance(covariance_);
}

void DriftFilter::check() {
  if (sound()) return;
  ++faults_;
  const std::vector<double> headings = heading_rad_;
  start();
  for (std::size_t i = 0; i < count_; ++i) move_to(i, headings[i], kAnewSigmaRad);
}

void DriftFilter::predict(double dt_s) {
  if (dt_s <= 0) return;
  const auto n = static_cast<Index>(count_);
  const double remembered = std::exp(-dt_s / kGapMemory_s);
  for (double& gaps : gaps_rad2_s_) gaps *= remembered;
  for (std::size_t i = 0; i < count_; ++i)
    heading_rad_[i] = wrap_heading(heading_rad_[i] + rate_rad_s_[i] * dt_s);
  // F P F^T: headings integrate their rates. Then the process noise.
  covariance_.topRows(n) += dt_s * covariance_.middleRows(n, n);
  covariance_.leftCols(n) += dt_s * covariance_.middleCols(n, n);
  mirror_lower(covariance_);
  const double rate_rad2 = rate_scale_.variance_factor() * settings_.rate_walk * settings_.rate_walk * dt_s;
  covariance_.diagonal().head(n).array() += settings_.heading_walk * settings_.heading_walk * dt_s;
  covariance_.topLeftCorner(n, n).array() += settings_.common_walk * settings_.common_walk * dt_s;
  // Half of a rate's walk is the ear sensor's bias, the same for all.
  covariance_.diagonal().segment(n, n).array() += 0.5 * rate_rad2;
  covariance_.block(n, n, n, n).array() += 0.5 * rate_rad2;
  covariance_.diagonal().tail(3 * n + 3).array() +=
      creep_scale_.variance_factor() * settings_.creep_walk * settings_.creep_walk * dt_s;
}

void DriftFilter::correct(double innovation_rad, double noise_rad2) {
  spread_.noalias() = covariance_ * observation_;
  const double expected_rad2 = observation_.dot(spread_) + noise_rad2;
  update_covariance(covariance_, spread_, expected_rad2);
  const double correction = innovation_rad / expected_rad2;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!present_[i]) continue;
    const auto of_creep = spread_.segment<3>(creep(i));
    creep_scale_.add(i, correction * of_creep, of_creep.squaredNorm() / expected_rad2);
    const double of_rate = spread_[rate(i)];
    rate_scale_.add(i, Vec3(correction * of_rate, 0, 0), of_rate * of_rate / expected_rad2);
  }
  spread_ *= correction;  // The states' change.
  for (std::size_t i = 0; i < count_; ++i) {
    // Heading errors are estimate less truth, so they are subtracted.
    heading_rad_[i] = wrap_heading(heading_rad_[i] - spread_[static_cast<Index>(i)]);
    rate_rad_s_[i] -= spread_[rate(i)];
    creep_rad_[i] += spread_.segment<3>(creep(i));
  }
  ear_creep_rad_ += spread_.segment<3>(ear());
  changed_ += spread_;
}

void DriftFilter::add_nod(std::size_t sensor, const NodMeasurement& nod) {
  observation_.setZero();
  observation_[static_cast<Index>(sensor)] = 1;
  correct(nod.error_rad, nod.sigma_rad * nod.sigma_rad);
}

void DriftFilter::follow_presence(double dt_s) {
  const bool most = 2 * std::ranges::count(present_, true) >= static_cast<std::ptrdiff_t>(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    if (!present_[i]) {
      if (most) absent_s_[i] += dt_s;
      continue;
    }
    if (std::exchange(absent_s_[i], 0.0) > settings_.taken_off_s)
      covariance_.diagonal().segment<3>(creep(i)).array() += settings_.put_on_rad * settings_.put_on_rad;
  }
}

void DriftFilter::follow_walks(double dt_s) {
  // Rates that walk faster are off by more already; what they have in common with headings stays.
  if (const double grown = rate_scale_.advance(dt_s); grown > 1) {
    const double most = kMostOfFirstRate2 * settings_.rate_sigma_rad_s * settings_.rate_sigma_rad_s;
    for (std::size_t i = 0; i < count_; ++i) {
      const double by = std::sqrt(std::clamp(most / covariance_(rate(i), rate(i)), 1.0, grown));
      covariance_.row(rate(i)) *= by;
      covariance_.col(rate(i)) *= by;
    }
  }
  // The walk of creep that the window lacked. Its variance is not scaled: creep that all sensors have in
  // common nothing measures, and it would grow without end.
  const double before = creep_scale_.variance_factor();
  if (creep_scale_.advance(dt_s) > 1)
    covariance_.diagonal().tail(3 * static_cast<Index>(count_) + 3).array() +=
        (creep_scale_.variance_factor() - before) * settings_.creep_walk * settings_.creep_walk *
        kCreepWindow_s;
}

void DriftFilter::learn(double dt_s) {
  for (std::size_t i = 0; i < count_; ++i) {
    const auto at = static_cast<Index>(3 * i);
    if (!present_[i]) {
      // For a moment it is where it was.
      if (!directed_[i]) deviation_rad_.segment<3>(at).setZero();
      continue;
    }
    observed_s_[i] += dt_s;
    const Vec3 level_rad = turn_rad_[i] - level_.offset_rad().segment<3>(at);
    if (observed_s_[i] < settings_.mean_s)
      mean_rad_.segment<3>(at) +=
          (dt_s / (kFirstMean_s + observed_s_[i])) * (level_rad - mean_rad_.segment<3>(at));
    deviation_rad_.segment<3>(at) = level_rad - mean_rad_.segment<3>(at);
  }
  for (std::size_t i = 0; i < count_; ++i)
    for (std::size_t j = 0; present_[i] && j < count_; ++j) {
      if (!present_[j]) continue;
      const auto row = static_cast<Index>(3 * i), column = static_cast<Index>(3 * j);
      const double known_s = std::min({observed_s_[i], observed_s_[j], settings_.memory_s});
      wearer_rad2_.block<3, 3>(row, column) +=
          (dt_s / (settings_.people_s + known_s)) *
          (deviation_rad_.segment<3>(row) * deviation_rad_.segment<3>(column).transpose() -
           wearer_rad2_.block<3, 3>(row, column));
    }
}

void DriftFilter::find_directions() {
  bool others = false;
  // A missing sensor's axes are directions of their own, which no measurement uses.
  distribution_rad2_ = wearer_rad2_;
  for (std::size_t i = 0; i < count_; ++i) {
    const bool directed = present_[i] || (directed_[i] && differs_s_[i] <= kGoneAfter_s);
    others = others || directed != directed_[i];
    directed_[i] = directed;
    if (directed) continue;
    const auto at = static_cast<Index>(3 * i);
    distribution_rad2_.middleRows<3>(at).setZero();
    distribution_rad2_.middleCols<3>(at).setZero();
    distribution_rad2_.block<3, 3>(at, at) = kMissingRad2 * Mat3::Identity();
    deviation_rad_.segment<3>(at).setZero();
  }
  directions_.compute(distribution_rad2_);
  if (others) level_.interrupt();
  directions_s_ = 0;
  std::ranges::fill(waited_s_, 0.0);
}

void DriftFilter::observe(Index direction, const Vec3& up) {
  observation_.setZero();
  for (std::size_t i = 0; i < count_; ++i) {
    if (!present_[i]) continue;
    const Vec3 part = directions_.eigenvectors().col(direction).segment<3>(static_cast<Index>(3 * i));
    observation_[static_cast<Index>(i)] = part.dot(turn_by_heading(turn_rad_[i], up));
    observation_.segment<3>(creep(i)) = part;
    observation_.segment<3>(ear()) -= part;
  }
}

void DriftFilter::add_skin(double dt_s, std::span<const std::optional<Vec3>> turn_rad,
                           std::span<const double> tilt_rad2, const Vec3& up) {
  if (dt_s <= 0 || count_ == 0) return;
  for (std::size_t i = 0; i < count_; ++i) {
    present_[i] = turn_rad[i].has_value();
    turn_rad_[i] = turn_rad[i].value_or(Vec3::Zero());
  }
  follow_walks(dt_s);
  follow_presence(dt_s);
  learn(dt_s);
  since_start_s_ += dt_s;
  directions_s_ += dt_s;
  bool others = false;  // Not for a moment only.
  for (std::size_t i = 0; i < count_; ++i) {
    differs_s_[i] = present_[i] == directed_[i] ? 0 : differs_s_[i] + dt_s;
    others = others || differs_s_[i] > (present_[i] ? kBackAfter_s : kGoneAfter_s);
  }
  if (others || directions_s_ > std::clamp(0.5 * since_start_s_, kSoonest_s, kLatest_s)) {
    check();
    find_directions();
  }
  for (double& waited : waited_s_) waited += dt_s;
  level_.add(dt_s, deviation_rad_, directions_, 0.5 * kMissingRad2);

  along_rad_.noalias() = directions_.eigenvectors().transpose() * deviation_rad_;
  const double least_rad2 = settings_.least_sigma_rad * settings_.least_sigma_rad;
  const Eigen::VectorXd& variance_rad2 = directions_.eigenvalues();
  double strength2 = 0, usable = 0;
  for (Index k = 0; k < along_rad_.size(); ++k) {
    if (variance_rad2[k] >= 0.5 * kMissingRad2) continue;
    strength2 +=
        std::min(kMostOfOne2, along_rad_[k] * along_rad_[k] / std::max(least_rad2, variance_rad2[k]));
    ++usable;
  }
  if (usable == 0) return;
  strength2 = std::clamp(strength2 / usable, kLeastStrength * kLeastStrength, kMostStrength * kMostStrength);

  // One direction a frame: all of them twice a second with eleven sensors. While a sensor is lost, as after a
  // gap, all in a tenth of that.
  changed_.setZero();
  bool lost = false;
  for (std::size_t i = 0; i < count_; ++i) {
    const double heading_rad2 = covariance_(static_cast<Index>(i), static_cast<Index>(i));
    lost = lost || (present_[i] && heading_rad2 > kLostRad2 && heading_rad2 < kAnywhereRad2);
  }
  for (std::size_t looks = lost ? kLooksAtLost : 1; looks > 0; --looks) {
    next_ = (next_ + 1) % waited_s_.size();
    measure(static_cast<Index>(next_), strength2, tilt_rad2, up);
  }
}

void DriftFilter::measure(Index direction, double strength2, std::span<const double> tilt_rad2,
                          const Vec3& up) {
  const double least_rad2 = settings_.least_sigma_rad * settings_.least_sigma_rad;
  const Eigen::VectorXd& variance_rad2 = directions_.eigenvalues();
  double& waiting_s = waited_s_[static_cast<std::size_t>(direction)];
  if (waiting_s <= 0 || variance_rad2[direction] >= 0.5 * kMissingRad2) return;
  const auto along = directions_.eigenvectors().col(direction);
  double absent = 0;
  for (std::size_t i = 0; i < count_; ++i)
    if (!present_[i]) absent += along.segment<3>(static_cast<Index>(3 * i)).squaredNorm();
  if (absent > kMostAbsent) return;
  const double waited_s = std::exchange(waiting_s, 0.0);
  observe(direction, up);
  // What the frame's measurements before have corrected is no deviation any more.
  const double innovation_rad = along_rad_[direction] - observation_.dot(changed_);
  spread_.noalias() = covariance_ * observation_;
  const double uncertain_rad2 = observation_.dot(spread_);
  // The states' own errors are in the wearer's covariance, too, but for those of a lost sensor.
  const double states_rad2 = uncertain_rad2 > kLostRad2 ? 0 : uncertain_rad2;
  const double skin_rad2 = std::max(least_rad2, variance_rad2[direction] - states_rad2);
  double noise_rad2 = std::max(least_rad2, strength2 * skin_rad2);
  for (std::size_t i = 0; i < count_; ++i)
    noise_rad2 += tilt_rad2[i] * along.segment<3>(static_cast<Index>(3 * i)).squaredNorm();
  // What gaps have added lately, a second.
  double gaps_rad2_s = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double heading = observation_[static_cast<Index>(i)];
    gaps_rad2_s += heading * heading * gaps_rad2_s_[i];
  }
  double correlation_s =
      std::min(settings_.correlation_s, settings_.first_correlation_s + kCorrelationGrowth * since_start_s_);
  if (gaps_rad2_s * correlation_s > kGapShare * noise_rad2)
    correlation_s =
        std::min(correlation_s, std::max(kGapCorrelation_s, kGapShare * noise_rad2 / gaps_rad2_s));
  const double at_gate_rad2 = innovation_rad * innovation_rad / (settings_.gate * settings_.gate);
  if (at_gate_rad2 > uncertain_rad2 + noise_rad2) {
    if (kGapMemory_s * gaps_rad2_s < kSoftGateShare * noise_rad2) return;
    noise_rad2 = at_gate_rad2 - uncertain_rad2;
  }
  // States less certain than the skin, as after a gap: one look at it counts in full.
  if (uncertain_rad2 > std::max(noise_rad2, kLostRad2)) {
    correct(innovation_rad, noise_rad2);
    return;
  }
  correct(innovation_rad,
          noise_rad2 * level_.variance_factor(along) * std::max(1.0, correlation_s / waited_s));
}

void DriftFilter::observe_axis(std::size_t sensor, Index axis, const Vec3& turn_rad, const Vec3& up) {
  observation_.setZero();
  observation_[static_cast<Index>(sensor)] = turn_by_heading(turn_rad, up)[axis];
  observation_[creep(sensor) + axis] = 1;
  observation_[ear() + axis] = -1;
}

void DriftFilter::expect_moved(std::size_t sensor, const Vec3& turn_rad, const Vec3& up) {
  const double about_up_rad = kHeadingShare * turn_rad.dot(up);
  covariance_(static_cast<Index>(sensor), static_cast<Index>(sensor)) += about_up_rad * about_up_rad;
  covariance_.diagonal().segment<3>(creep(sensor)).array() += turn_rad.squaredNorm();
  // What was learnt of its skin since is of another place, and its mean where that was not known yet.
  const auto at = static_cast<Index>(3 * sensor);
  wearer_rad2_.middleRows<3>(at).setZero();
  wearer_rad2_.middleCols<3>(at).setZero();
  wearer_rad2_.block<3, 3>(at, at) = people_rad2_.block<3, 3>(at, at);
  directions_s_ = kLatest_s;
  const bool known = observed_s_[sensor] >= settings_.mean_s;
  observed_s_[sensor] = known ? settings_.mean_s : 0;
  if (!known) mean_rad_.segment<3>(at).setZero();
}

void DriftFilter::correct_ear_by_rest(std::span<const Vec3> turn_rad, std::span<const Resting> resting,
                                      const Vec3& up) {
  if (resting.size() < kLeastForEar) return;
  Vec3 median_rad;
  std::vector<double> axis_rad(turn_rad.size());
  for (Index axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < turn_rad.size(); ++k) axis_rad[k] = turn_rad[k][axis];
    const auto middle = axis_rad.begin() + static_cast<std::ptrdiff_t>(axis_rad.size() / 2);
    std::ranges::nth_element(axis_rad, middle);
    median_rad[axis] = *middle;
  }
  // The mean of all sensors, by the median that one of them does not move.
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(3, covariance_.cols());
  for (const Resting& one : resting)
    for (Index axis = 0; axis < 3; ++axis) {
      observe_axis(one.sensor, axis, median_rad, up);
      mean.row(axis) += observation_.transpose() / static_cast<double>(resting.size());
    }
  double noise_rad2 = 0;
  for (const Resting& one : resting)
    noise_rad2 += one.sigma_rad * one.sigma_rad / static_cast<double>(resting.size());
  const Mat3 expected_rad2 = mean * covariance_ * mean.transpose() + noise_rad2 * Mat3::Identity();
  if (median_rad.dot(expected_rad2.ldlt().solve(median_rad)) < kRestGate2) return;
  covariance_.diagonal().segment<3>(ear()).array() += median_rad.squaredNorm();
  const double about_up_rad = kHeadingShare * median_rad.dot(up);
  const auto n = static_cast<Index>(count_);
  covariance_.topLeftCorner(n, n).array() += about_up_rad * about_up_rad;
  changed_.setZero();
  for (Index axis = 0; axis < 3; ++axis) {
    observation_ = mean.row(axis).transpose();
    correct(median_rad[axis] - observation_.dot(changed_), noise_rad2);
  }
}

void DriftFilter::observe_rest(std::span<const std::optional<Vec3>> turn_rad,
                               std::span<const double> sigma_rad, const Vec3& up) {
  // At rest nothing is held.
  level_.release();
  std::vector<Resting> resting;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!turn_rad[i]) continue;
    resting.push_back(
        {i, sigma_rad[i], exp_rotation(*turn_rad[i]), heading_rad_[i], exp_rotation(creep_rad_[i])});
    if (covariance_(static_cast<Index>(i), static_cast<Index>(i)) < kAnywhereRad2) continue;
    // The heading that brings it nearest to neutral, whatever it was.
    const Quat& turn = resting.back().turn;
    heading_rad_[i] = wrap_heading(heading_rad_[i] - 2 * std::atan2(turn.vec().dot(up), turn.w()));
  }
  const Quat ear_before = exp_rotation(-ear_creep_rad_);
  std::vector<Vec3> left_rad(resting.size());
  const auto left = [&](const Resting& one) {
    const double turned_rad = wrap_heading(heading_rad_[one.sensor] - one.heading_rad);
    return log_rotation(exp_rotation(ear_creep_rad_) * ear_before * exp_rotation(turned_rad * up) * one.turn *
                        one.creep * exp_rotation(-creep_rad_[one.sensor]));
  };
  std::ranges::transform(resting, left_rad.begin(), left);
  correct_ear_by_rest(left_rad, resting, up);
  for (const Resting& one : resting) {
    const Vec3 off_rad = left(one);
    const Mat3 expected_rad2 =
        states_covariance(one.sensor, up) + one.sigma_rad * one.sigma_rad * Mat3::Identity();
    if (off_rad.dot(expected_rad2.ldlt().solve(off_rad)) >= kRestGate2) expect_moved(one.sensor, off_rad, up);
  }
  // In the limit of small rotations the steps are one measurement of `sigma_rad`.
  for (int step = 0; step < kRestSteps; ++step)
    for (const Resting& one : resting) {
      const Vec3 off_rad = left(one);
      changed_.setZero();
      for (Index axis = 0; axis < 3; ++axis) {
        observe_axis(one.sensor, axis, off_rad, up);
        correct(off_rad[axis] - observation_.dot(changed_), kRestSteps * one.sigma_rad * one.sigma_rad);
      }
    }
  check();
}

}  // namespace mien::imu
