#include "mien/imu/prologue.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mien/core/units.h"

namespace mien::imu {
namespace {

/// Least number of frames of a hold, and of a nod: half a second.
constexpr std::size_t kMinFrames = 30;
/// A nod has begun when the head has turned this far from neutral.
constexpr double kFirstTurn = 4 * kRadPerDeg;
/// Longest interval of frames from which angular acceleration is differentiated, s.
constexpr double kMaxStep_s = 0.05;
/// Least lever arm of the face sensors ahead of the ear, m, and least acceleration that a nod makes of it,
/// m/s^2 per radian of the head's turn, for the sign of ahead to be taken from the nod's swing. Usual are
/// 0.09 and, at half a hertz, 0.9 (docs/method/calibration.md); accelerometer errors, which turn with the
/// head, reach 0.1 to 0.3.
constexpr double kMinAhead_m = 0.03;
constexpr double kMinSwing_m_s2_rad = 0.4;

// Limits of the scores. A nod of 10 degrees determines the heading to a few degrees; the others show a step
// that was not done as asked.
constexpr double kMaxStillRate = 4 * kRadPerDeg;   // Head's RMS rate in the hold, rad/s.
constexpr double kMaxFaceSpread = 2 * kRadPerDeg;  // Worst sensor against the head in the hold, rad.
constexpr double kMinNod = 10 * kRadPerDeg;
constexpr double kMinShake = 10 * kRadPerDeg;
constexpr double kMinAxisShare = 0.8;
constexpr double kMaxNodTilt = 20 * kRadPerDeg;    // Nod's axis from the horizontal, rad.
constexpr double kMaxShakeTilt = 20 * kRadPerDeg;  // Shake's axis from the vertical, rad.
constexpr double kMaxHeadingSigma = 3 * kRadPerDeg;

/// Whether the face sensors are ahead of the head's sensor (1), behind it (-1) or beside it (0), by the rig's
/// positions; 1 without positions.
double face_side(const sensor::Rig& rig) {
  double sum_m = 0, count = 0;
  for (const std::uint16_t index : rig.face_sensors()) {
    if (!rig.sensors[index].position_m) continue;
    sum_m += rig.sensors[index].position_m->z();
    ++count;
  }
  const auto head = rig.head_sensor();
  if (count == 0 || !head || !rig.sensors[*head].position_m) return 1;
  const double ahead_m = sum_m / count - rig.sensors[*head].position_m->z();
  return std::abs(ahead_m) < kMinAhead_m ? 0 : std::copysign(1.0, ahead_m);
}

}  // namespace

void Prologue::Sway::add(const Vec3& rate_rad_s, double angle_rad) {
  rate_square += rate_rad_s * rate_rad_s.transpose();
  ++count;
  largest_rad = std::max(largest_rad, angle_rad);
}

Vec3 Prologue::Sway::axis() const {
  return Eigen::SelfAdjointEigenSolver<Mat3>(rate_square).eigenvectors().col(2);
}

double Prologue::Sway::axis_share() const {
  const double all = rate_square.trace();
  return all > 0 ? Eigen::SelfAdjointEigenSolver<Mat3>(rate_square).eigenvalues()[2] / all : 0;
}

double Prologue::Sway::rms_rad_s() const {
  return count > 0 ? std::sqrt(rate_square.trace() / static_cast<double>(count)) : 0;
}

void Prologue::Swing::add(double accel_m_s2, const Vec3& turn_rad_s2) {
  ++count;
  accel += accel_m_s2;
  turn += turn_rad_s2;
  product += accel_m_s2 * turn_rad_s2;
  turn_square += turn_rad_s2 * turn_rad_s2.transpose();
}

double Prologue::Swing::covariance(const Vec3& left) const {
  return left.dot(product) - left.dot(turn) * accel / static_cast<double>(count);
}

double Prologue::Swing::variance(const Vec3& left) const {
  return left.dot(turn_square * left) - left.dot(turn) * left.dot(turn) / static_cast<double>(count);
}

double Prologue::ahead_m(const Vec3& left) const {
  double covariance = 0, variance = 0, count = 0;
  for (const Swing& swing : swing_) {
    if (swing.count < kMinFrames) continue;
    covariance += swing.covariance(left);
    variance += swing.variance(left);
    count += static_cast<double>(swing.count);
  }
  if (!(variance > 0)) return 0;
  // A head that starts to nod down moves what is ahead of the ear down: left x ahead = -up.
  const double ahead = -face_side_ * covariance / variance;
  // A slow nod gives little acceleration, and accelerometer errors turn with the head.
  const double rate2 = left.dot(nodding_.rate_square * left) / static_cast<double>(nodding_.count);
  const double swing_m_s2_rad = std::abs(ahead) * (variance / count) / rate2;
  return std::abs(ahead) >= kMinAhead_m && swing_m_s2_rad >= kMinSwing_m_s2_rad ? ahead : 0;
}

Prologue::Prologue(const sensor::Rig& rig) : face_side_(face_side(rig)) {
  for (const std::uint16_t index : rig.face_sensors()) {
    names_.push_back(rig.sensors[index].name);
    outward_.push_back(rig.sensors[index].outward);
  }
  begin_neutral();
}

void Prologue::begin_neutral() {
  hold_.assign(names_.size(), {});
  force_.assign(names_.size(), {});
  ear_sum_.setZero();
  ear_up_sum_.setZero();
  still_ = {};
  begin_nod();
  begin_shake();
}

void Prologue::begin_nod() {
  nod_.assign(names_.size(), {});
  nodding_ = {};
  swing_.assign(names_.size(), {});
  last_nod_.reset();
  first_turn_.reset();
}

void Prologue::begin_shake() {
  shaking_ = {};
}

Vec3 Prologue::from_neutral(const Quat& q_world_ear) const {
  if (still_.count == 0) return Vec3::Zero();
  const Quat neutral = fit_rotation(Mat3(ear_sum_.transpose()));
  return log_rotation(neutral.conjugate() * q_world_ear);
}

void Prologue::add_neutral(const Frame& frame) {
  const Mat3 ear = frame.q_world_ear.toRotationMatrix();
  ear_sum_ += ear;
  ear_up_sum_ += ear.row(1).transpose();
  still_.add(frame.ear_rate_rad_s, 0);
  for (std::size_t i = 0; i < frame.face.size(); ++i) {
    if (!frame.face[i].present) continue;
    hold_[i].add(frame.q_world_ear, frame.face[i].q_world_face);
    const Vec3& f = frame.face[i].force_world_m_s2;
    // R_h^T (Z f - f_h), with Z f = (0, y, 0) + cos (x, 0, z) + sin (z, 0, -x).
    force_[i].constant += ear.transpose() * (Vec3(0, f.y(), 0) - frame.ear_force_world_m_s2);
    force_[i].cosine += ear.transpose() * Vec3(f.x(), 0, f.z());
    force_[i].sine += ear.transpose() * Vec3(f.z(), 0, -f.x());
  }
}

void Prologue::add_nod(const Frame& frame) {
  const Vec3 turn = from_neutral(frame.q_world_ear);
  nodding_.add(frame.ear_rate_rad_s, turn.norm());
  if (!first_turn_ && turn.norm() > kFirstTurn) first_turn_ = turn;
  const double step_s = last_nod_ ? to_seconds(frame.time - last_nod_->time) : 0;
  for (std::size_t i = 0; i < frame.face.size(); ++i) {
    if (!frame.face[i].present) continue;
    nod_[i].add(frame.q_world_ear, frame.face[i].q_world_face);
    if (step_s > 0 && step_s <= kMaxStep_s && frame.ear_fresh && frame.face[i].fresh)
      swing_[i].add(frame.face[i].force_world_m_s2.y() - frame.ear_force_world_m_s2.y(),
                    (frame.ear_rate_rad_s - last_nod_->rate_rad_s) / step_s);
  }
  if (frame.ear_fresh) last_nod_ = {frame.time, frame.ear_rate_rad_s};
}

void Prologue::add_shake(const Frame& frame) {
  shaking_.add(frame.ear_rate_rad_s, from_neutral(frame.q_world_ear).norm());
}

bool Prologue::judge_hold(Calibration& out) const {
  if (still_.count < kMinFrames) {
    out.scores.push_back(
        {"neutral", 0, "", false,
         "the head sensor sent nothing while you held still; check it and hold still again"});
    return false;
  }
  const double still_dps = still_.rms_rad_s() / kRadPerDeg;
  out.scores.push_back({"neutral", still_dps, "dps", still_.rms_rad_s() <= kMaxStillRate,
                        still_.rms_rad_s() <= kMaxStillRate
                            ? "the head held still"
                            : "the head moved; hold still for three seconds again"});
  return true;
}

double Prologue::find_headings(Calibration& out) const {
  double worst_spread = 0;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    SensorCalibration& sensor = out.sensors[i];
    if (hold_[i].count() < kMinFrames || nod_[i].count() < kMinFrames) continue;
    HeadingSums both = hold_[i];
    both += nod_[i];
    const HeadingSums::Best best = both.find();
    sensor.valid = true;
    sensor.heading_rad = best.heading_rad;
    sensor.heading_sigma_rad = best.sigma_rad;
    sensor.neutral = hold_[i].mean(best.heading_rad);
    worst_spread = std::max(worst_spread, hold_[i].spread(best.heading_rad));
  }
  return worst_spread;
}

std::optional<Vec3> Prologue::judge_nod(const Vec3& up, Calibration& out) const {
  // A nod down turns the head about its left axis by the right hand.
  const Vec3 nod_axis = nodding_.axis();
  const Vec3 level = nod_axis - up * up.dot(nod_axis);
  const double nod_tilt = std::asin(std::clamp(std::abs(up.dot(nod_axis)), 0.0, 1.0));
  const double share = nodding_.axis_share();
  const bool nodded = first_turn_.has_value() && nodding_.largest_rad >= kMinNod;
  out.scores.push_back(
      {"nod", nodding_.largest_rad / kRadPerDeg, "deg", nodded,
       nodded ? "the nod was large enough" : "the nod was too small; nod by 15 degrees or more"});
  const bool straight = nod_tilt <= kMaxNodTilt && share >= kMinAxisShare;
  out.scores.push_back({"nod axis", nod_tilt / kRadPerDeg, "deg", straight,
                        straight ? "the nod was straight"
                                 : "the nod was mixed with other turns; nod straight down and up again"});
  if (!first_turn_ || level.norm() < 0.1) return std::nullopt;
  const Vec3 left = level.normalized();
  return left.dot(*first_turn_) < 0 ? Vec3(-left) : left;
}

Vec3 Prologue::judge_direction(const Vec3& up, Vec3 left, Calibration& out) const {
  // The lever arm by the nod's swing, then the mean outward axis, take precedence over the nod's beginning,
  // which may have been lost or done the other way.
  Vec3 outward = Vec3::Zero();
  for (std::size_t i = 0; i < names_.size(); ++i)
    if (outward_[i] && out.sensors[i].valid) outward += out.sensors[i].neutral * *outward_[i];
  const double swing_m = ahead_m(left);
  const bool swung = swing_m != 0;
  const bool down_first = !swung || swing_m > 0;
  if (!down_first) left = -left;
  if (outward.norm() > 0.1) {
    const bool agree = left.cross(up).dot(outward) > 0;
    if (!agree && !swung) left = -left;
    out.scores.push_back(
        {"nod direction", agree ? 1.0 : 0.0, "", agree,
         agree ? "the sensors' outward axes say the same of which way is ahead"
         : swung
             ? "the sensors' outward axes are wrong: the face swings as if it were behind them; mend the rig"
             : "the nod began upwards, or the sensors' outward axes are wrong; nod down first"});
  } else if (swung) {
    out.scores.push_back({"nod direction", 1, "", true,
                          down_first ? "the nod began downwards, as the face's swing says too"
                                     : "the nod's beginning was missed or upwards; the face's swing told "
                                       "which way is ahead"});
  }
  return left;
}

void Prologue::judge_shake(const Vec3& up, Calibration& out) const {
  if (shaking_.count < kMinFrames) return;
  const double off = std::acos(std::clamp(std::abs(up.dot(shaking_.axis())), 0.0, 1.0));
  const bool good = off <= kMaxShakeTilt && shaking_.largest_rad >= kMinShake;
  out.scores.push_back(
      {"shake", off / kRadPerDeg, "deg", good,
       good ? "the shake was about the vertical that gravity gives"
            : "the shake was small or not about the vertical; sit upright and calibrate again"});
}

void Prologue::judge_sensors(Calibration& out) const {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    SensorCalibration& sensor = out.sensors[i];
    if (!sensor.valid) {
      out.scores.push_back({"heading " + names_[i], 180, "deg", false,
                            "the sensor was silent in the prologue; check it and calibrate again"});
      continue;
    }
    const bool good = sensor.heading_sigma_rad <= kMaxHeadingSigma;
    out.scores.push_back(
        {"heading " + names_[i], sensor.heading_sigma_rad / kRadPerDeg, "deg", good,
         good ? "the nod gave this sensor's heading"
              : "the nod does not tell how this sensor is headed; keep the face still and nod wider"});
    const ForceSums& f = force_[i];
    sensor.neutral_accel_m_s2 =
        out.q_head_ear *
        Vec3(f.constant + std::cos(sensor.heading_rad) * f.cosine + std::sin(sensor.heading_rad) * f.sine) /
        static_cast<double>(hold_[i].count());
  }
}

Calibration Prologue::solve() const {
  Calibration out;
  out.sensors.resize(names_.size());
  if (!judge_hold(out)) return out;
  const double worst_spread = find_headings(out);
  if (nodding_.count < kMinFrames) return out;
  out.scores.push_back({"neutral face", worst_spread / kRadPerDeg, "deg", worst_spread <= kMaxFaceSpread,
                        worst_spread <= kMaxFaceSpread
                            ? "the face held still"
                            : "the face moved while holding still; relax and hold still again"});

  // C: up from gravity, left from the nod's axis.
  const Vec3 up = ear_up_sum_.normalized();
  const std::optional<Vec3> axis = judge_nod(up, out);
  if (!axis) return out;
  const Vec3 left = judge_direction(up, *axis, out);
  Mat3 to_head;
  to_head.row(0) = left.transpose();
  to_head.row(1) = up.transpose();
  to_head.row(2) = left.cross(up).transpose();
  out.q_head_ear = canonical(Quat(to_head));
  const Quat neutral_ear = fit_rotation(Mat3(ear_sum_.transpose()));
  const Vec3 ahead = neutral_ear * (out.q_head_ear.conjugate() * Vec3::UnitZ());
  out.neutral_heading_rad = std::atan2(ahead.x(), ahead.z());
  out.complete = true;
  judge_shake(up, out);
  judge_sensors(out);
  return out;
}

}  // namespace mien::imu
