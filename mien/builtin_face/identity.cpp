#include "mien/builtin_face/identity.h"

#include <algorithm>
#include <cmath>

#include "mien/builtin_face/anatomy.h"

namespace mien::builtin_face {
namespace {

double smooth_bump(const Vec3& p, const Vec3& centre, const Vec3& inverse_radius) {
  const double q = (p - centre).cwiseProduct(inverse_radius).squaredNorm();
  return q < 1 ? (1 - q) * (1 - q) : 0;
}
Vec3 flip(const Vec3& p) {
  return {-p.x(), p.y(), p.z()};
}
Vec3 inverse(double x, double y, double z) {
  return {1 / x, 1 / y, 1 / z};
}

}  // namespace

IdentityWarp::IdentityWarp(const BuiltinParameters& parameters) : q_(parameters) {
  for (double* value : {&q_.head_width, &q_.face_length, &q_.jaw_width, &q_.chin_size, &q_.nose_length,
                        &q_.nose_width, &q_.nose_bridge, &q_.eye_spacing, &q_.eye_size, &q_.mouth_width,
                        &q_.lip_fullness, &q_.cheekbones, &q_.cheek_fullness, &q_.brow_ridge, &q_.brow_height,
                        &q_.forehead_height, &q_.ear_size, &q_.neck_width})
    *value = std::clamp(*value, -3.0, 3.0);
  q_.asymmetry = std::clamp(q_.asymmetry, 0.0, 3.0);

  const auto bump = [&](double amount, const Vec3& centre, const Vec3& radius, const Vec3& d, bool both) {
    if (amount != 0) bumps_.push_back({centre, radius.cwiseInverse(), amount * d, both});
  };
  bump(q_.chin_size, {0, -68, 98}, {44, 40, 50}, {0, -2.0, 2.4}, false);
  bump(q_.nose_length, {0, -1, 120}, {28, 32, 38}, {0, -0.9, 2.1}, false);
  bump(q_.nose_bridge, {0, 24, 110}, {20, 32, 32}, {0, 0.2, 1.7}, false);
  bump(q_.eye_spacing, {36, 36, 85}, {44, 50, 60}, {1.2, 0, -0.2}, true);
  bump(q_.cheekbones, {52, 14, 70}, {34, 36, 46}, {1.9, 0, 1.2}, true);
  bump(q_.cheek_fullness, {44, -22, 76}, {36, 40, 50}, {2.1, 0, 1.8}, true);
  bump(q_.brow_ridge, {24, 54, 98}, {40, 22, 34}, {0, -0.2, 1.1}, true);
  bump(q_.brow_height, {28, 58, 96}, {44, 24, 44}, {0, 1.3, -0.1}, true);
  if (q_.asymmetry_seed != 0 && q_.asymmetry > 0) {
    Random random(q_.asymmetry_seed);
    for (int i = 0; i < 10; ++i) {
      const Vec3 centre{random.uniform(-60, 60), random.uniform(-75, 70), random.uniform(70, 105)};
      const double radius = random.uniform(38, 60);
      // Statements apart: the order of draws is part of the result.
      Vec3 d;
      for (int k = 0; k < 3; ++k) d[k] = random.normal();
      bump(0.55 * q_.asymmetry, centre, {radius, radius, radius}, d, false);
    }
  }
  eye_scale_ = 1 + 0.026 * q_.eye_size;
  eye_shift_ = {shift(kEyeCentre), shift(flip(kEyeCentre))};
}

Vec3 IdentityWarp::shift(const Vec3& p) const {
  Vec3 d = Vec3::Zero();
  const double x = p.x(), y = p.y();
  d.x() += 0.024 * q_.head_width * x;
  if (y < 10 && q_.face_length != 0) {
    const double t = std::min((10 - y) / 90, 1.3);
    d.y() -= 2.8 * q_.face_length * t * t / (t + 0.25);
  }
  if (q_.jaw_width != 0)
    d.x() += 0.05 * q_.jaw_width * x * smooth_bump(p, {0, -52, 40}, inverse(130, 62, 120));
  if (q_.nose_width != 0)
    d.x() += 0.095 * q_.nose_width * x * smooth_bump(p, {0, -2, 112}, inverse(26, 24, 34));
  if (q_.mouth_width != 0)
    d.x() += 0.05 * q_.mouth_width * x * smooth_bump(p, {0, -34, 104}, inverse(58, 36, 54));
  if (q_.lip_fullness != 0) {
    const double w = q_.lip_fullness * smooth_bump(p, {0, -34, 110}, inverse(32, 20, 26));
    d += Vec3(0, 0.12 * (y - lip_line_y(x)), 0.7) * w;
  }
  d.y() += 2.2 * q_.forehead_height * smoothstep(62, 140, y);
  if (q_.neck_width != 0) {
    const double w = 0.032 * q_.neck_width * smoothstep(-70, -125, y - 0.3 * std::max(0.0, p.z() - 30));
    d += w * Vec3(x, 0, p.z() + 20);
  }
  for (const Bump& b : bumps_) {
    d += smooth_bump(p, b.centre, b.inverse_radius) * b.shift;
    if (b.both) d += smooth_bump(flip(p), b.centre, b.inverse_radius) * flip(b.shift);
  }
  return d;
}

Vec3 IdentityWarp::operator()(const Vec3& p) const {
  Vec3 d = shift(p);
  for (std::size_t e = 0; e < 2; ++e) {
    const Vec3 arm = p - (e == 0 ? kEyeCentre : flip(kEyeCentre));
    const double r2 = arm.squaredNorm();
    if (r2 > 38 * 38) continue;
    const double near = smoothstep(38, 17, std::sqrt(r2));
    d = (1 - near) * d + near * (eye_shift_[e] + (eye_scale_ - 1) * arm);
  }
  return p + d;
}

Vec3 IdentityWarp::ear(const Vec3& p) const {
  const Vec3 root(p.x() > 0 ? 71.5 : -71.5, 18, 2);
  return (*this)(root) + (1 + 0.05 * q_.ear_size) * (p - root);
}

}  // namespace mien::builtin_face
