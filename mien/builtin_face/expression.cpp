#include "mien/builtin_face/expression.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include "mien/builtin_face/anatomy.h"
#include "mien/core/units.h"
#include "mien/face/profile.h"

namespace mien::builtin_face {
namespace {

using V = SculptVertex;

/// 1 at `centre`, 0 beyond the ellipsoid of radii `r`, smooth between.
double bell(const Vec3& p, const Vec3& centre, const Vec3& r) {
  const Vec3 off = p - centre;
  if ((off.array().abs() >= r.array()).any()) return 0;  // Most are far away: no division for them.
  const double q = off.cwiseQuotient(r).squaredNorm();
  return q < 1 ? (1 - q) * (1 - q) * (1 + 0.5 * q) : 0;
}
double upper(const V& v) {
  return 0.5 + 0.5 * v.lip_side;
}
double lower(const V& v) {
  return 0.5 - 0.5 * v.lip_side;
}
bool is_fixed(const V& v) {
  switch (v.tissue) {
    case Tissue::ear:
    case Tissue::eyeball:
    case Tissue::caruncle:
    case Tissue::teeth_upper:
    case Tissue::gums_upper:
    case Tissue::cloth:
      return true;
    default:
      return false;
  }
}
bool follows_jaw_rigidly(const V& v) {
  return v.tissue == Tissue::teeth_lower || v.tissue == Tissue::gums_lower || v.tissue == Tissue::tongue;
}
/// Skin, and what grows on it or lines the mouth.
bool is_soft(const V& v) {
  return !is_fixed(v) && !follows_jaw_rigidly(v);
}
/// Lids keep to the eyeball and their corners to the bone: other muscles' pull fades out on them.
double off_lids(const V& v) {
  return (1 - smoothstep(0.0, 0.85, std::abs(v.lid))) * off_canthi(v.anchor);
}

/// How far a vertex goes with the lower jaw: 1 on chin and lower lip, 0 above the mouth and at the neck's
/// foot.
double jaw_share(const V& v) {
  if (is_fixed(v)) return 0;
  if (follows_jaw_rigidly(v)) return 1;
  const Vec3& p = v.anchor;
  if (v.tissue == Tissue::mouth) return lower(v) * smoothstep(18, 70, p.z());
  const double share = smoothstep(0, 1, lower(v));
  const double back = smoothstep(-5, 55, p.z() + 0.25 * (p.y() + 60));
  const double neck = smoothstep(-124, -72, p.y() + 0.25 * (p.z() - 60));
  // The cheek hangs from the bone above as well as from the jaw.
  const double azimuth = std::atan2(std::abs(p.x()), std::max(p.z() - 10, 1.0));
  const double hangs = mix(1.0, 0.52, smoothstep(6, 30, azimuth / kRadPerDeg));
  return share * back * neck * hangs;
}
Vec3 jaw_turn(const V& v, double angle) {
  const double share = jaw_share(v);
  if (share == 0) return Vec3::Zero();
  const Vec3 arm = v.p - kJawHinge;
  return Eigen::AngleAxisd(angle * share, Vec3::UnitX()) * arm - arm;
}

/// The mouth's lining goes with the lips, but is held by the bone where it turns over onto the gums.
double off_bone(const V& v) {
  if (v.tissue != Tissue::mouth) return 1;
  const double from_line = std::abs(v.anchor.y() - lip_line_y(v.anchor.x()));
  return smoothstep(12, 4, from_line) * smoothstep(76, 90, v.anchor.z());
}

enum class Lips { both, upper, lower };

/// Skin about `centre` goes by `d`.
Vec3 push(const V& v, const Vec3& centre, const Vec3& r, const Vec3& d, Lips lips = Lips::both) {
  if (!is_soft(v)) return Vec3::Zero();
  double w = bell(v.anchor, centre, r) * off_bone(v);
  if (w == 0) return Vec3::Zero();
  if (lips == Lips::upper) w *= upper(v);
  if (lips == Lips::lower) w *= lower(v);
  return w * off_lids(v) * d;
}

/// The same on both sides.
Vec3 push_both(const V& v, const Vec3& centre, const Vec3& r, const Vec3& d, Lips which = Lips::both) {
  return push(v, centre, r, d, which) + push(v, flip(centre), r, flip(d), which);
}

/// How high lies a place of the left eye, about its lateral axis: rad.
double elevation(const Vec3& p) {
  return std::atan2(p.y() - kEyeCentre.y(), p.z() - kEyeCentre.z());
}

/// The margins of the left eye's lids, as the mesh has them, and how lids turn about the eyeball.
class Lids {
 public:
  explicit Lids(const Sculpt& whole) {
    // Where a lid's skin ends its inside begins.
    for (const auto& t : whole.triangles[static_cast<std::size_t>(Piece::lids)])
      for (const std::uint32_t i : t) {
        const V& v = whole.vertices[i];
        if (v.tissue == Tissue::skin && v.p.x() > 0)
          (v.lid > 0 ? upper_ : lower_).emplace_back(v.p.x(), elevation(v.p));
      }
    std::ranges::sort(upper_);
    std::ranges::sort(lower_);
  }

  /// By the share `up_close` of the way from open to closed for the upper lid, `low_close` for the lower
  /// (negative opens); `sideways` turns both about the vertical, rad.
  [[nodiscard]] Vec3 operator()(const V& v, double up_close, double low_close, double sideways = 0) const {
    if (v.lid == 0 || v.anchor.x() < 0 || !is_soft(v)) return Vec3::Zero();
    const double x = v.anchor.x();
    const double open_u = margin(upper_, x), open_l = std::min(margin(lower_, x), open_u);
    const double meet = mix(open_l, open_u, 0.16);
    const double share = smoothstep(0.04, 0.94, std::abs(v.lid));
    // Away from the margin the fold of the lid unrolls less toward its corners.
    const double s = lid_fraction(x);
    const double middle = mix(smoothstep(-0.02, 0.42, s) * smoothstep(1.04, 0.7, s), 1.0,
                              smoothstep(0.55, 0.95, std::abs(v.lid)));
    const double angle = middle * (v.lid > 0 ? (open_u - meet) * up_close : (open_l - meet) * low_close);
    const Vec3 arm = v.p - kEyeCentre;
    const double side = sideways * smoothstep(0.3, 1.0, std::abs(v.lid)) *
                        smoothstep(0, 6, std::min(x - kInnerCanthusX, kOuterCanthusX - x));
    const Vec3 turned =
        Eigen::AngleAxisd(side, Vec3::UnitY()) * (Eigen::AngleAxisd(angle * share, Vec3::UnitX()) * arm);
    // Half a weight moves along the chord: what closes goes a little out, so that half closed clears the
    // cornea.
    const double closes = std::clamp(v.lid > 0 ? up_close : low_close, 0.0, 1.0);
    return (1 + 0.03 * closes * share) * turned - arm;
  }

 private:
  using Margin = std::vector<std::pair<double, double>>;  ///< x (mm) and elevation (rad), ascending.

  static double margin(const Margin& margin, double x) {
    const auto after = std::ranges::lower_bound(margin, x, {}, &std::pair<double, double>::first);
    if (after == margin.begin()) return margin.front().second;
    if (after == margin.end()) return margin.back().second;
    const auto& [x0, e0] = *(after - 1);
    return mix(e0, after->second, (x - x0) / std::max(after->first - x0, 1e-9));
  }

  Margin upper_, lower_;
};

/// How far up (mm) a lower lip goes that slides `way` (mm) along the upper one.
double along_lips(const V& v, double way) {
  const double x = v.anchor.x();
  return lip_line_y(x + way) - lip_line_y(x);
}

/// 0 where the lips meet, 1 from `mm` away: what presses lips together moves not where they touch.
double off_seal(const V& v, double mm) {
  return smoothstep(0, mm, std::abs(v.anchor.y() - lip_line_y(v.anchor.x())));
}

const Vec3 kCorner{kMouthCornerX, kMouthCornerY, 103};
constexpr double kJawOpen = 21.5 * kRadPerDeg;

/// How far the mouth rises when its corners are drawn up, as a share of theirs: little in its middle.
double bow(const V& v) {
  const double s = std::min(1.0, std::abs(v.anchor.x()) / kMouthCornerX);
  return mix(0.18, 1.0, s * s);
}

Vec3 close_lips(const V& v) {
  if (!is_soft(v)) return Vec3::Zero();
  const Vec3 open = jaw_turn(v, kJawOpen);
  // The lips come back all the way, the skin below less and less down to the chin.
  double keep = smoothstep(-76, -42, v.anchor.y());
  if (v.tissue == Tissue::lip) keep = 1;
  if (v.tissue == Tissue::mouth) keep = off_bone(v);
  keep *= smoothstep(70, 30, std::abs(v.anchor.x()));
  const Vec3 down = Vec3(0, -4.0, 0.6) * bell(v.anchor, {0, -33, 108}, {34, 30, 45});
  return -keep * open + down;
}

/// Draws the red of one lip in between the teeth; the skin beside it follows to the line where the lips meet.
Vec3 roll(const V& v, bool up) {
  if (!is_soft(v)) return Vec3::Zero();
  const Vec3& p = v.anchor;
  const double x = std::abs(p.x());
  const double s = std::min(1.0, x / (kMouthCornerX + 1));
  const double side = up ? upper(v) : lower(v);
  const double line = lip_line_y(x);
  const double border = up ? upper_lip_border_y(x) : lower_lip_border_y(x);
  const double from_line = std::abs(p.y() - line), red = std::abs(border - line);
  const double across = off_bone(v) * side * (1 - s * s) * (1 - smoothstep(red + 1, red + 13, from_line));
  if (across <= 0) return Vec3::Zero();
  const double inward = 1 - smoothstep(0.6 * red, red + 6, from_line);
  const double deep = smoothstep(97, 109, p.z());  // the gums' side of the lip stays
  // Everything on the red comes to the line; beyond it the skin is drawn after it by as much as the border
  // moves.
  const double slide = -(up ? 1 : -1) * std::min(from_line, red) * (up ? 0.85 : 0.90);
  return deep * across * Vec3(0, slide + (up ? -0.8 : 1.3), -(up ? 8.5 : 9.6) * inward);
}

/// A left shape or one of the midline, by its name without side.
struct LeftShape {
  // NOLINTNEXTLINE(google-explicit-constructor): names stand for shapes below.
  consteval LeftShape(const char* name)
      : index(face::shape_index(name) < face::kShapeCount ? face::shape_index(name) : with_side(name)) {}
  static consteval std::size_t with_side(std::string_view name) {
    std::size_t k = 0;
    while (!face::kShapeNames[k].ends_with("_L") || face::kShapeNames[k].substr(0, name.size()) != name ||
           face::kShapeNames[k].size() != name.size() + 2)
      ++k;
    return k;
  }
  std::size_t index;
};

/// Left shapes and shapes of the midline.
Vec3 displacement(std::size_t shape, const V& v, const Lids& lids) {
  const auto is = [shape](LeftShape s) { return s.index == shape; };
  // Brow.
  if (is("browDown"))
    return push(v, {20, 62, 101}, {32, 29, 45}, {-2.8, -5.2, 0.6}) +
           push(v, {40, 59, 90}, {26, 26, 40}, {-0.6, -2.4, 0});
  if (is("browInnerUp")) return push(v, {13, 60, 104}, {42, 40, 50}, {0.6, 6.2, 0.2});
  if (is("browOuterUp")) return push(v, {42, 59, 88}, {32, 36, 45}, {1.2, 8.0, -1.2});
  // Lids.
  if (is("eyeBlink")) return lids(v, 1, 1) + push(v, {34, 22, 92}, {24, 16, 30}, {-0.4, 0.6, 0});
  if (is("eyeLookDown")) return lids(v, 0.62, -0.65);
  if (is("eyeLookUp")) return lids(v, -0.29, 0.62);
  if (is("eyeLookIn")) return lids(v, 0.03, 0.0, -0.13);
  if (is("eyeLookOut")) return lids(v, 0.03, 0.0, 0.13);
  if (is("eyeSquint")) return lids(v, 0.14, 1.25) + push(v, {36, 20, 92}, {26, 20, 36}, {-0.7, 2.8, 1.0});
  if (is("eyeWide")) return lids(v, -0.24, -0.40) + push(v, {30, 52, 96}, {24, 16, 30}, {0, 0.7, 0});
  // Cheeks.
  if (is("cheekPuff"))
    return push(v, {42, -26, 88}, {36, 38, 60}, {10.5, -0.5, 9.5}) +
           push(v, {14, -20, 110}, {22, 14, 30}, {0.5, 0, 3.0}) +
           push(v, {14, -46, 106}, {22, 14, 30}, {0.5, 0, 2.5});
  if (is("cheekSquint"))
    return push(v, {40, 8, 88}, {32, 34, 50}, {0.8, 5.0, 2.2}) +
           push(v, {44, -12, 86}, {52, 56, 70}, {0.2, 1.9, 0.4}) + lids(v, 0.0, 0.4);
  if (is("noseSneer"))
    return push(v, {29, -9, 101}, {30, 38, 50}, {1.8, 10.0, 1.0}) +
           push(v, {12, 24, 104}, {16, 22, 30}, {-0.5, 2.2, 1.0}) +
           push(v, {14, 54, 102}, {20, 16, 30}, {-0.5, -1.5, 0});
  // Jaw.
  if (is("jawForward"))
    return jaw_share(v) * Vec3(0, 0.3, 11.2) + push(v, {0, -27, 112}, {28, 13, 40}, {0, 0, 1.6}, Lips::upper);
  if (is("jawLeft"))
    return jaw_share(v) * Vec3(9.0, along_lips(v, 6.6), 0.0) +
           push(v, {0, -28, 112}, {30, 16, 40}, {2.4, 0, 0}, Lips::upper);
  if (is("jawOpen")) return jaw_turn(v, kJawOpen);
  if (is("mouthClose")) return close_lips(v);
  // Mouth.
  if (is("mouthDimple"))
    return push(v, kCorner, {22, 20, 40}, {6.8, 1.4, -6.0}) +
           push(v, {42, -30, 92}, {14, 18, 30}, {-0.5, 0, 1.0});
  if (is("mouthFrown"))
    return push(v, kCorner, {26, 26, 45}, {1.2, -6.6, -1.2}) +
           push(v, {10, -52, 104}, {20, 16, 30}, {0, 1.5, 0.8});
  if (is("mouthFunnel"))
    return push(v, {0, -27, 113}, {28, 16, 40}, {0, 4.0, 9.4}, Lips::upper) +
           push(v, {0, -40, 112}, {28, 18, 40}, {0, -5.4, 9.0}, Lips::lower) +
           push_both(v, kCorner, {23, 25, 40}, {-9.0, 0, 5.5});
  if (is("mouthLeft"))
    return push(v, {2, -34, 108}, {52, 34, 60}, {17, 1.0, 0.0}) +
           push(v, kCorner, {26, 24, 45}, {1.5, 2.5, -6.0});
  if (is("mouthLowerDown")) return push(v, {11, -40, 110}, {24, 22, 40}, {0.6, -4.9, -0.4}, Lips::lower);
  if (is("mouthPress"))
    return push(v, {13, -28, 111}, {20, 9, 40}, {0.3, -2.0 * off_seal(v, 4), -3.4}, Lips::upper) +
           push(v, {13, -39, 110}, {20, 10, 40}, {0.3, 2.4 * off_seal(v, 4), -3.4}, Lips::lower) +
           push(v, kCorner, {18, 18, 40}, {1.4, -0.3, -2.0});
  if (is("mouthPucker"))
    return push(v, {0, -33.5, 112}, {26, 22, 45}, {0, 0, 7.5}) +
           push_both(v, kCorner, {26, 26, 50}, {-10.5, 0.3, 4.5}) +
           push_both(v, {34, -42, 92}, {56, 50, 80}, {-1.6, 0.3, 1.4});
  if (is("mouthRollLower")) return roll(v, false);
  if (is("mouthRollUpper")) return roll(v, true);
  if (is("mouthShrugLower"))
    return push(v, {0, -60, 106}, {32, 30, 50}, {0, 10.6 * off_seal(v, 9), 1.5}, Lips::lower) +
           push(v, {0, -32, 112}, {32, 18, 40}, {0, 5.4, 3.4});
  if (is("mouthShrugUpper")) return push(v, {0, -30, 112}, {30, 21, 40}, {0, 5.7, 2.4});
  if (is("mouthSmile"))
    // The corner goes up and back along the cheek, the lips thin over the teeth, the cheek rises into the
    // lower lid and leaves a fold beside the nose.
    return push(v, kCorner, {35, 31, 55}, {8.4, 10.2 * bow(v), -4.6}) +
           push(v, {12, -27, 111}, {24, 15, 40}, {1.2, 0.2 * off_seal(v, 5), -2.0}, Lips::upper) +
           push(v, {0, -39, 111}, {28, 14, 40}, {0, 1.4 * off_seal(v, 5), -2.0}, Lips::lower) +
           push(v, {41, 1, 90}, {28, 26, 40}, {1.2, 4.6, 4.4}) +
           push(v, {28, -15, 101}, {8, 22, 26}, {0.4, 1.0, -2.6}) +
           push(v, {39, -12, 94}, {13, 22, 30}, {0.6, 1.0, 2.6}) + lids(v, 0.04, 0.5) +
           push(v, {32, -28, 92}, {66, 62, 80}, {1.0, 1.9, -0.6});
  if (is("mouthStretch"))
    return push(v, kCorner, {30, 28, 50}, {9.0, -3.6, -5.0}) +
           push(v, {28, -60, 92}, {24, 24, 40}, {2.0, -1.5, 0});
  if (is("mouthUpperUp"))
    return push(v, {12, -26, 111}, {24, 22, 40}, {1.0, 7.0, 0.6}, Lips::upper) +
           push(v, {25, -14, 102}, {22, 24, 40}, {0.6, 4.4, 0.4}) +
           push(v, {37, -5, 94}, {22, 20, 36}, {0.8, 3.6, 3.4});
  return Vec3::Zero();
}

Vec3 tongue_out(const V& v) {
  // The jaw drops a little, the lips part, the tongue comes out over the lower lip.
  Vec3 d = jaw_turn(v, 7.5 * kRadPerDeg);
  if (v.tissue == Tissue::tongue) {
    // Up over the teeth, out over the lip, the tip hanging a little.
    const double s = std::clamp((v.p.z() - 44) / 48, 0.0, 1.0);
    d += Vec3(0, 10.5 * smoothstep(0.2, 0.65, s) - 8.0 * smoothstep(0.8, 1.0, s), 37 * s * (0.4 + 0.6 * s));
    d.x() -= 0.12 * v.p.x() * s;
  }
  d += push(v, {0, -27, 113}, {24, 12, 40}, {0, 1.4, 0.6}, Lips::upper) +
       push(v, {0, -40, 112}, {26, 16, 40}, {0, -3.2, 0.4}, Lips::lower);
  return d;
}

/// Lids never sink into the eyeball when a shape is full on. `lid_skin`: vertices of lids' outside.
void keep_off_eyeballs(const Sculpt& whole, std::span<const std::uint32_t> lid_skin, std::vector<Vec3>& d) {
  for (const std::uint32_t i : lid_skin) {
    const V& v = whole.vertices[i];
    if (d[i].squaredNorm() == 0) continue;
    const Vec3 centre = v.p.x() > 0 ? kEyeCentre : flip(kEyeCentre);
    const Vec3 arm = v.p + d[i] - centre;
    const double least = kLidRadius - 0.25;
    if (arm.norm() < least) d[i] += arm.normalized() * (least - arm.norm());
  }
}

/// `about_mouth`: vertices that may touch teeth.
void keep_off_teeth(const Sculpt& whole, std::span<const std::uint32_t> about_mouth, std::vector<Vec3>& d) {
  for (const std::uint32_t i : about_mouth) {
    if (d[i].squaredNorm() == 0) continue;
    const Vec3& home = whole.vertices[i].p;
    d[i] += out_of_teeth(kUpperArch, true, home, home + d[i]);
    d[i] += out_of_teeth(kLowerArch, false, home, home + d[i]);
  }
}

template <class Wanted>
std::vector<std::uint32_t> pick(const Sculpt& whole, const Wanted& wanted) {
  std::vector<std::uint32_t> picked;
  for (std::uint32_t i = 0; i < whole.vertices.size(); ++i)
    if (wanted(whole.vertices[i])) picked.push_back(i);
  return picked;
}

/// The shape that is the mirror image of `k`; kShapeCount where there is none.
constexpr std::size_t right_one_of(std::size_t k) {
  if (k == face::shape("jawLeft")) return face::shape("jawRight");
  if (k == face::shape("mouthLeft")) return face::shape("mouthRight");
  return face::kShapeNames[k].ends_with("_L") ? k + 1 : face::kShapeCount;
}
constexpr bool is_right_one(std::size_t k) {
  return face::kShapeNames[k].ends_with("_R") || k == face::shape("jawRight") ||
         k == face::shape("mouthRight");
}

}  // namespace

void sculpt_shapes(const Sculpt& whole, const TakeShape& take) {
  const Lids lids(whole);
  const TuneShape tune = kinematics_tuner(whole);
  const std::vector<std::uint32_t> moving = pick(whole, [](const V& v) { return !is_fixed(v); });
  const std::vector<std::uint32_t> lid_skin =
      pick(whole, [](const V& v) { return v.tissue == Tissue::skin && std::abs(v.lid) >= 0.05; });
  const std::vector<std::uint32_t> about_mouth = pick(whole, may_touch_teeth);
  std::vector<Vec3> left(whole.vertices.size(), Vec3::Zero()), right = left;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    if (is_right_one(k)) continue;
    for (const std::uint32_t i : moving) left[i] = displacement(k, whole.vertices[i], lids);
    keep_off_eyeballs(whole, lid_skin, left);
    tune(k, left);
    const std::size_t mirrored = right_one_of(k);
    if (mirrored != face::kShapeCount)
      for (const std::uint32_t i : moving) right[whole.mirror[i]] = flip(left[i]);
    const bool jaw_stays = !face::kShapeNames[k].starts_with("jaw") && k != face::shape("mouthClose");
    if (jaw_stays) keep_off_teeth(whole, about_mouth, left);
    take(k, left);
    if (mirrored == face::kShapeCount) continue;
    if (jaw_stays) keep_off_teeth(whole, about_mouth, right);
    take(mirrored, right);
  }
  for (const std::uint32_t i : moving) left[i] = tongue_out(whole.vertices[i]);
  take(face::kShapeCount, left);
}

}  // namespace mien::builtin_face
