#include "mien/imu/nod_watch.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mien::imu {

void NodWatch::begin(const Quat& q_ear_face) {
  stretch_s_ = 0;
  n_ = 0;
  from_ = q_ear_face;
  world_sum_.setZero();
  turn_sum_.setZero();
  world_turn_sum_.setZero();
  turn_turn_ = 0;
}

std::optional<NodMeasurement> NodWatch::add(double dt_s, const Quat& q_ear_face, const Quat& q_world_ear,
                                            const Vec3& rate_rad_s, const Vec3& head_rate_rad_s) {
  smooth_rate_ += std::min(1.0, dt_s / 0.1) * (rate_rad_s - smooth_rate_);
  if (smooth_rate_.norm() > settings_.still_rad_s + settings_.still_share * head_rate_rad_s.norm()) {
    still_s_ = 0;
    return std::nullopt;
  }
  const bool was_still = still_s_ >= settings_.still_s;
  still_s_ += dt_s;
  if (still_s_ < settings_.still_s) return std::nullopt;
  if (!was_still || stretch_s_ > settings_.max_stretch_s) begin(q_ear_face);

  const Vec3 turn = log_rotation(q_ear_face * from_.conjugate());
  const Mat3 world_ear = q_world_ear.toRotationMatrix();
  stretch_s_ += dt_s;
  n_ += 1;
  world_sum_ += world_ear;
  turn_sum_ += turn;
  world_turn_sum_ += world_ear * turn;
  turn_turn_ += turn.squaredNorm();

  // Least squares of turn = R_h^T e + constant, the constant eliminated, the inclinations by their prior.
  const double frame2 = settings_.frame_sigma_rad * settings_.frame_sigma_rad * settings_.correlated_frames;
  const double hold = frame2 / (settings_.tilt_sigma_rad * settings_.tilt_sigma_rad);
  const Mat3 normal = Mat3(Mat3::Identity() * n_ - world_sum_ * world_sum_.transpose() / n_);
  Mat3 held = normal;
  held(0, 0) += hold;
  held(2, 2) += hold;
  // A pure turn about the vertical leaves the heading unobservable: a row of zeros, no inverse.
  if (normal(1, 1) < settings_.min_information) return std::nullopt;
  const Mat3 inverse = held.inverse();
  const double information = 1 / inverse(1, 1);
  if (!(information > settings_.min_information)) return std::nullopt;

  const Vec3 right = world_turn_sum_ - world_sum_ * turn_sum_ / n_;
  const Vec3 error = inverse * right;
  const double all = turn_turn_ - turn_sum_.squaredNorm() / n_;
  const double residual2 = std::max(0.0, all - 2 * error.dot(right) + error.dot(normal * error)) / n_;
  begin(q_ear_face);
  if (residual2 >= settings_.max_residual_rad * settings_.max_residual_rad) return std::nullopt;
  const double noise2 = std::max(frame2, residual2 * settings_.correlated_frames);
  return NodMeasurement{error.y(), std::sqrt(noise2 / information)};
}

}  // namespace mien::imu
