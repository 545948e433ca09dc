#include "mien/builtin_face/identity.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/held.h"

namespace mien::builtin_face {
namespace {

double smooth_bump(const Vec3& p, const Vec3& centre, const Vec3& inverse_radius) {
  const double q = (p - centre).cwiseProduct(inverse_radius).squaredNorm();
  return q < 1 ? (1 - q) * (1 - q) : 0;
}
Vec3 inverse(double x, double y, double z) {
  return {1 / x, 1 / y, 1 / z};
}

}  // namespace

BuiltinParameters leaning(const BuiltinParameters& parameters) {
  BuiltinParameters q = held(parameters);
  // Men's faces are longer and wider below, with brow ridge, nose and neck, and thinner lips (directions and
  // order of size after Farkas 1994, "Anthropometry of the head and face": men's faces are 5 to 8 % larger in
  // width and length, most so at the jaw).
  const double man = q.sex;
  q.head_width += 0.35 * man;
  q.face_length += 0.5 * man;
  q.jaw_width += 0.45 * man;
  q.jaw_angle += 0.7 * man;
  q.chin_size += 0.45 * man;
  q.chin_width += 0.7 * man;
  q.nose_length += 0.35 * man;
  q.nose_bridge += 0.3 * man;
  q.lip_fullness -= 0.5 * man;
  q.brow_ridge += 0.9 * man;
  q.brow_height -= 0.5 * man;
  q.brow_fullness += 0.7 * man;
  q.forehead_slope += 0.5 * man;
  q.lid_opening -= 0.35 * man;
  q.neck_width += 0.9 * man;
  // With age ears grow by 0.22 mm a year (Heathcote 1995, doi:10.1136/bmj.311.7021.1668), the nose's tip
  // sinks, the upper lip lengthens and thins, brows and lids come down, and temples and cheeks hollow above
  // the jowls (Mendelson and Wong 2012, doi:10.1007/s00266-012-9904-3). 0 at 30, 1 at 70 years.
  const double old = (q.age_years - 30) / 40;
  q.ear_size += 1.9 * old;
  q.nose_length += 0.5 * old;
  q.nose_tip -= 0.9 * old;
  q.lip_fullness -= 0.8 * old;
  q.philtrum_length += 0.7 * old;
  q.brow_height -= 0.6 * old;
  q.lid_opening -= 1.0 * old;
  q.temple_width -= 0.7 * old;
  return held(q);
}

IdentityWarp::IdentityWarp(const BuiltinParameters& parameters) : q_(leaning(parameters)) {
  add_bumps();
  add_asymmetry();
  const double scale = 1 + 0.026 * q_.eye_size, slant = 2 * M_PI / 180 * q_.eye_slant;
  for (std::size_t e = 0; e < 2; ++e)
    eye_turn_[e] = scale * Eigen::AngleAxisd(e == 0 ? slant : -slant, Vec3::UnitZ()).toRotationMatrix();
  eye_shift_ = {shift(kEyeCentre), shift(flip(kEyeCentre))};
}

void IdentityWarp::add_bump(const Bump& bump) {
  assert(bumps_.size() < kMostBumps);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double reach = 1 / bump.inverse_radius[a] + 1e-3;
    const std::size_t last = slice_of(bump.centre[a] + reach);
    for (std::size_t slice = slice_of(bump.centre[a] - reach); slice <= last; ++slice)
      reach_[axis][slice] |= std::uint64_t{1} << bumps_.size();
  }
  bumps_.push_back(bump);
}

void IdentityWarp::add_bumps() {
  const auto bump = [&](double amount, const Vec3& centre, const Vec3& radius, const Vec3& d, bool both) {
    if (amount == 0) return;
    add_bump({centre, radius.cwiseInverse(), amount * d});
    if (both) add_bump({flip(centre), radius.cwiseInverse(), flip(amount * d)});
  };
  bump(q_.chin_size, {0, -68, 98}, {44, 40, 50}, {0, -2.0, 2.4}, false);
  bump(q_.nose_length, {0, -1, 120}, {28, 32, 38}, {0, -0.9, 2.1}, false);
  bump(q_.nose_bridge, {0, 24, 110}, {20, 32, 32}, {0, 0.2, 1.7}, false);
  bump(q_.eye_spacing, {36, 36, 85}, {44, 50, 60}, {1.2, 0, -0.2}, true);
  bump(q_.cheekbones, {52, 14, 70}, {34, 36, 46}, {1.9, 0, 1.2}, true);
  bump(q_.cheek_fullness, {44, -22, 76}, {36, 40, 50}, {2.1, 0, 1.8}, true);
  bump(q_.brow_ridge, {24, 54, 98}, {40, 22, 34}, {0, -0.2, 1.1}, true);
  bump(q_.brow_height, {28, 58, 96}, {44, 24, 44}, {0, 1.3, -0.1}, true);
  bump(q_.face_fullness, {50, -34, 58}, {46, 56, 58}, {2.2, -0.3, 0.9}, true);
  bump(q_.face_fullness, {0, -84, 56}, {46, 34, 54}, {0, -2.0, 0.8}, false);
  bump(q_.jaw_angle, {60, -40, 26}, {38, 38, 48}, {2.4, -0.9, 0}, true);
  bump(q_.nose_tip, {0, -2, 122}, {24, 22, 26}, {0, 1.2, 0.2}, false);
  bump(q_.nose_root, {0, 37, 104}, {17, 24, 26}, {0, 0, 1.5}, false);
  bump(q_.alar_width, {0, 0, 124}, {22, 22, 26}, {0, 0, -0.8}, false);
  bump(q_.lip_projection, {0, -34, 114}, {34, 22, 30}, {0, 0, 1.1}, false);
  bump(q_.philtrum_length, {0, -42, 104}, {66, 34, 66}, {0, -1.3, 0}, false);
  bump(q_.temple_width, {68, 62, 38}, {34, 42, 54}, {2.0, 0, 0}, true);
  const double old = (q_.age_years - 30) / 40;
  bump(old, {42, -54, 70}, {28, 26, 40}, {0.9, -2.0, 0.6}, true);    // jowls
  bump(old, {40, -14, 84}, {26, 24, 34}, {-0.6, -0.5, -1.1}, true);  // hollow cheeks
}

void IdentityWarp::add_asymmetry() {
  if (q_.asymmetry_seed == 0 || q_.asymmetry <= 0) return;
  Random random(q_.asymmetry_seed);
  for (int i = 0; i < 10; ++i) {
    const Vec3 centre{random.uniform(-60, 60), random.uniform(-75, 70), random.uniform(70, 105)};
    const double radius = random.uniform(38, 60);
    // Statements apart: the order of draws is part of the result.
    Vec3 d;
    for (int k = 0; k < 3; ++k) d[k] = random.normal();
    add_bump({centre, Vec3::Constant(1 / radius), 0.55 * q_.asymmetry * d});
  }
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
  if (q_.alar_width != 0)
    d.x() += 0.10 * q_.alar_width * x * smooth_bump(p, {0, -4, 112}, inverse(24, 17, 24));
  if (q_.chin_width != 0)
    d.x() += 0.11 * q_.chin_width * x * smooth_bump(p, {0, -68, 96}, inverse(44, 26, 46));
  if (q_.lip_fullness != 0) {
    const double w = q_.lip_fullness * smooth_bump(p, {0, -34, 110}, inverse(32, 20, 26));
    if (w != 0) d += Vec3(0, 0.12 * (y - lip_line_y(x)), 0.7) * w;
  }
  if (q_.forehead_slope != 0)
    d.z() -= 2.2 * q_.forehead_slope * smoothstep(62, 120, y) * smoothstep(10, 80, p.z());
  d.y() += 2.2 * q_.forehead_height * smoothstep(62, 140, y);
  if (q_.neck_width != 0) {
    const double w = 0.032 * q_.neck_width * smoothstep(-70, -125, y - 0.3 * std::max(0.0, p.z() - 30));
    d += w * Vec3(x, 0, p.z() + 20);
  }
  // In the order in which they were added, whoever reaches here: sums stay the same to the last bit.
  for (std::uint64_t reaching = reach_[0][slice_of(x)] & reach_[1][slice_of(y)] & reach_[2][slice_of(p.z())];
       reaching != 0; reaching &= reaching - 1) {
    const Bump& b = bumps_[static_cast<std::size_t>(std::countr_zero(reaching))];
    d += smooth_bump(p, b.centre, b.inverse_radius) * b.shift;
  }
  return d;
}

Vec3 IdentityWarp::fold_shift(std::size_t e, const Vec3& p) const {
  // A lid without a crease hangs over its margin; one that lies deeper than the default's shows less of it.
  const double amount = q_.eye_fold > 0 ? q_.eye_fold : 0.35 * q_.eye_fold;
  if (amount == 0) return Vec3::Zero();
  const Vec3 left = e == 0 ? p : flip(p);
  const double outside = smoothstep(kLidRadius + 0.1, kLidRadius + 2.6, (left - kEyeCentre).norm());
  const Vec3 d = smooth_bump(left, {33, 47, 98}, inverse(22, 10, 16)) * Vec3(0, -1.2, 1.3) +
                 smooth_bump(left, {16, 37, 94}, inverse(9, 9, 12)) * Vec3(1.0, -0.7, 0.8);
  return amount * outside * (e == 0 ? d : flip(d));
}

Vec3 IdentityWarp::operator()(const Vec3& p) const {
  Vec3 d = shift(p);
  for (std::size_t e = 0; e < 2; ++e) {
    const Vec3 arm = p - (e == 0 ? kEyeCentre : flip(kEyeCentre));
    const double r2 = arm.squaredNorm();
    if (r2 > 38 * 38) continue;
    const double near = smoothstep(38, 17, std::sqrt(r2));
    d = (1 - near) * d + near * (eye_shift_[e] + (eye_turn_[e] * arm - arm)) + fold_shift(e, p);
  }
  return p + d;
}

Vec3 IdentityWarp::ear(const Vec3& p) const {
  const double side = p.x() > 0 ? 1 : -1;
  const Vec3 root(side * 75.8, 14, 0);
  const Eigen::AngleAxisd out(side * 6 * M_PI / 180 * q_.ear_protrusion, Vec3::UnitY());
  return (*this)(root) + (1 + 0.05 * q_.ear_size) * (out * (p - root));
}

}  // namespace mien::builtin_face
