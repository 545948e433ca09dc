#include "mien/builtin_face/haircut.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <span>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/surface.h"
#include "mien/core/random.h"
#include "mien/core/toml.h"

namespace mien::builtin_face {

extern const std::string_view kHaircutsToml;  // haircuts.toml.

namespace {

/// Which way hair is combed: away from a point of the crown, away from a line from front to back, towards a
/// knot at the back.
enum class Flow : std::uint8_t { whorl, parted, back };

/// What makes a style: haircuts.toml says what each is. Lengths in mm.
struct Style {
  Flow flow;
  Vec3 pole;
  int ribbons;
  double width;
  int strands, joints;
  double top, side, nape;
  double lift, front;
  double gravity;
  double curl, turns;
  double spacing;
};

const Vec3 kHeadCentre(0, 52, 2);
constexpr double kPartingMm = 8;
constexpr double kRootMm = 2.5;  // Along which the hairs of a ribbon begin.

Style style_of(HairStyle style) {
  const toml::table file = parse_toml(kHaircutsToml, "haircuts.toml").value();
  const auto cut = file[kHairStyleNames[static_cast<std::size_t>(style)]];
  const auto number = [&cut](std::string_view key, double otherwise = 0) {
    return cut[key].value_or(otherwise);
  };
  constexpr std::string_view kFlows[] = {"whorl", "parted", "back"};
  const auto flow = std::ranges::find(kFlows, cut["flow"].value_or(std::string_view())) - kFlows;
  const auto pole = cut["pole"];
  return {.flow = static_cast<Flow>(flow),
          .pole = {pole[0].value_or(0.0), pole[1].value_or(0.0), pole[2].value_or(0.0)},
          .ribbons = cut["ribbons"].value_or(0),
          .width = number("width"),
          .strands = cut["strands"].value_or(0),
          .joints = cut["joints"].value_or(0),
          .top = number("top"),
          .side = number("side"),
          .nape = number("nape"),
          .lift = number("lift"),
          .front = number("front"),
          .gravity = number("gravity"),
          .curl = number("curl"),
          .turns = number("turns"),
          .spacing = number("spacing", 1.5)};
}

/// The head that hair lies on: with ears, which head_distance leaves out.
double scalp_distance(const Vec3& p) {
  const Vec3 q = (Vec3(std::abs(p.x()), p.y(), p.z()) - Vec3(77, 20, -6)).cwiseQuotient(Vec3(11, 33, 20));
  const double ear = (q.norm() - 1) * 11;
  return std::min(head_distance(p), ear);
}
/// The same for hair that hangs: it falls beside the face, not over it.
double hanging_distance(const Vec3& p) {
  const Vec3 radii(67, 86, 62);
  const double face = ((p - Vec3(0, 4, 92)).cwiseQuotient(radii).norm() - 1) * 62;
  return std::min(scalp_distance(p), face);
}
template <class Distance>
Vec3 outward(const Vec3& p, const Distance& distance) {
  // Differences along the corners of a tetrahedron.
  constexpr double kStep = 0.6;
  Vec3 sum = Vec3::Zero();
  for (const Vec3& k : {Vec3(1, -1, -1), Vec3(-1, -1, 1), Vec3(-1, 1, -1), Vec3(1, 1, 1)})
    sum += k * distance(p + kStep * k);
  return sum.normalized();
}

/// Where the ray from the head's centre along `direction` leaves the skin.
Vec3 scalp_point(const Vec3& direction) {
  return surface_along(kHeadCentre, direction,
                       {.from = 150, .most = 40, .share = 0.8, .near = 0.05, .least = 0.05}, head_distance);
}

/// Height of the hairline as a row of the sculptor, over the azimuth (degrees).
double hairline_row(double azimuth_deg) {
  constexpr double kPoints[][2] = {{0, 95},   {14, 96},  {26, 100}, {36, 102},  {44, 92},  {51, 74}, {57, 58},
                                   {63, 44},  {68, 20},  {71, 8},   {77, 5},    {81, 14},  {87, 44}, {98, 54},
                                   {108, 48}, {118, 24}, {128, 0},  {145, -24}, {180, -38}};
  for (std::size_t i = 0; i + 1 < std::size(kPoints); ++i)
    if (azimuth_deg <= kPoints[i + 1][0])
      return mix(kPoints[i][1], kPoints[i + 1][1], smoothstep(kPoints[i][0], kPoints[i + 1][0], azimuth_deg));
  return kPoints[std::size(kPoints) - 1][1];
}

Vec3 combed(const Style& style, const Vec3& p, const Vec3& normal) {
  Vec3 d = Vec3::Zero();
  switch (style.flow) {
    case Flow::whorl:
      d = p - style.pole;
      break;
    case Flow::parted: {
      // From the parting outwards on the crown, and down where the head falls away.
      const double side = std::tanh((p.x() - style.pole.x()) / 1.5);
      const double top = smoothstep(0.25, 0.8, normal.y());
      const double front = smoothstep(20, 80, p.z());
      d = Vec3(side * (0.2 + top), -1 + 0.7 * top, mix(-0.45, -0.25, front) * (0.3 + top));
      break;
    }
    case Flow::back:
      d = style.pole - p;
      break;
  }
  d -= d.dot(normal) * normal;
  return d.norm() > 1e-9 ? d.normalized() : Vec3(normal.unitOrthogonal());
}

double length_at(const Style& style, const Vec3& root) {
  const double crown = smoothstep(70, 112, root.y());
  const double nape = smoothstep(-20, -70, root.z()) * smoothstep(40, -10, root.y());
  return mix(mix(style.side, style.nape, nape), style.top, crown);
}

/// Joins points that lie one behind the other into a ribbon; `along` says where each is between root (0) and
/// tip (1).
void add_ribbon(Haircut& cut, std::span<const Vec3> spine, std::span<const Vec3> across, const Style& style,
                std::size_t number, const auto& along, const auto& half_width, const auto& shade) {
  const auto first = static_cast<std::uint32_t>(cut.p.size());
  const auto strand = static_cast<float>(number * static_cast<std::size_t>(style.strands) % 4096);
  for (std::size_t k = 0; k < spine.size(); ++k) {
    const double s = along(k);
    for (int side = 0; side < 2; ++side) {
      cut.p.push_back(spine[k] + (side == 0 ? -1 : 1) * half_width(s) * across[k]);
      cut.uv.emplace_back((strand + static_cast<float>(side * style.strands)) / face::kStrandsPerUv,
                          static_cast<float>(s));
      cut.shade.push_back(static_cast<float>(shade(s)));
    }
    if (k == 0) continue;
    const std::uint32_t a = first + static_cast<std::uint32_t>(2 * (k - 1));
    cut.triangles.push_back({a, a + 1, a + 3});
    cut.triangles.push_back({a, a + 3, a + 2});
  }
}

/// Grows one ribbon from `root`. `depth`: 0 lies on the scalp, 1 is the outermost hair.
void grow(const Style& style, Haircut& cut, const Vec3& root, double depth, std::size_t number,
          Random& random) {
  const double edge = smoothstep(0, 16, within_hairline(root));  // Hair at its edge is short and lies flat.
  const double front = smoothstep(30, 85, root.z()) * smoothstep(60, 95, root.y());
  const double fringe = style.flow == Flow::whorl ? mix(1.0, 0.68, front) : 1.0;  // Out of the eyes.
  const double length =
      length_at(style, root) * fringe * mix(0.55, 1.0, edge) * std::max(0.5, 1 + 0.13 * random.normal());
  const double crown = smoothstep(30, 110, root.y());
  const double lift = mix(mix(0.55, 1.0, crown) * style.lift, style.front, front) * mix(0.3, 1.0, edge) *
                      mix(0.15, 1.0, depth);
  // Hair keeps together in locks: neighbours stray the same way.
  const double lock =
      0.22 * std::sin(0.16 * root.x() + 0.11 * root.y() + 1.3) * std::sin(0.14 * root.z() + 0.7) +
      0.10 * std::sin(0.45 * root.x() + 2.1) * std::sin(0.38 * root.z() + 0.31 * root.y());
  const double stray = lock + (style.flow == Flow::back ? 0.03 : 0.10) * random.normal();
  const double twist = 0.28 * random.normal();
  const double phase = random.uniform(0, 2 * M_PI);
  const double brightness = 1 + 0.12 * random.normal();
  const double width = style.width * (1 + 0.2 * random.normal()) * mix(0.55, 1.0, edge);

  const auto distance = style.gravity > 0.5 ? hanging_distance : scalp_distance;
  Vec3 normal = outward(root, scalp_distance);
  Vec3 q = root + 0.2 * normal;
  std::vector<Vec3> spine, across;
  double way = 0;
  for (int k = 0; k <= style.joints; ++k) {
    const double s = way / length;
    Vec3 d = combed(style, q, normal);
    d = Eigen::AngleAxisd(stray, normal) * d;
    d = (1 - style.gravity * s) * d + style.gravity * s * Vec3(0, -1, 0);
    d.normalize();
    Vec3 side = normal.cross(d);
    if (side.norm() < 1e-6) side = normal.unitOrthogonal();
    side = Eigen::AngleAxisd(twist, d) * side.normalized();
    Vec3 at = q;
    if (style.curl > 0) {
      const double turn = phase + 2 * M_PI * style.turns * s, r = style.curl * smoothstep(0, 0.3, s);
      at += r * (std::cos(turn) * side + std::sin(turn) * normal);
    }
    spine.push_back(at);
    across.push_back(side);
    // Short pieces first: a long one from the root would cut through the scalp.
    const double next = length * std::pow((k + 1.0) / style.joints, style.spacing);
    q += (next - way) * d;
    way = next;
    // Never into the head; combed hair keeps to its height above it, hanging hair only stays outside.
    const double want = std::min(lift * smoothstep(0.0, 22.0, way + 4), 0.8 * way);
    const double now = distance(q);
    normal = outward(q, distance);
    const double keep = now < want ? 1.0 : 0.75 * (1 - style.gravity * smoothstep(0.1, 0.5, way / length));
    q += keep * (want - now) * normal;
  }
  add_ribbon(
      cut, spine, across, style, number,
      [&](std::size_t k) {
        // Hairs begin within the first tenth of a ribbon (render's strands): two or three millimetres of all.
        const double at = length * std::pow(static_cast<double>(k) / style.joints, style.spacing);
        return at < kRootMm ? 0.1 * at / kRootMm : mix(0.1, 1.0, (at - kRootMm) / (length - kRootMm));
      },
      [&](double s) {
        return 0.5 * width * mix(0.8, 1.0, std::sin(M_PI * s)) *
               (style.flow == Flow::back ? mix(1.0, 0.5, s) : 1.0);
      },
      [&](double s) {
        return brightness * mix(0.42, 1.0, depth) * mix(0.55, 1.0, smoothstep(0.0, 0.45, s));
      });
}

/// The knot of tied hair: ribbons wound about a ball.
void add_knot(const Style& style, Haircut& cut, Random random) {
  constexpr int kRibbons = 110;
  constexpr std::size_t kJoints = 9;
  for (int i = 0; i < kRibbons; ++i) {
    const double tilt = random.normal(0, 0.5), off = random.uniform(-0.85, 0.85);
    const double begin = random.uniform(0, 2 * M_PI), radius = 21 * random.uniform(0.82, 1.0);
    const double brightness = 1 + 0.15 * random.normal();
    const Vec3 axis = Vec3(std::sin(tilt), 0.35 * std::cos(2 * tilt), -std::cos(tilt)).normalized();
    const Vec3 a = axis.unitOrthogonal(), b = axis.cross(a);
    std::vector<Vec3> spine, across;
    for (std::size_t k = 0; k < kJoints; ++k) {
      const double turn = begin + 2.4 * static_cast<double>(k) / (kJoints - 1);
      const Vec3 out = (std::sqrt(1 - off * off) * (std::cos(turn) * a + std::sin(turn) * b) + off * axis);
      spine.push_back(style.pole + radius * out.cwiseProduct(Vec3(1.15, 1.0, 0.8)));
      across.push_back(out.cross(std::cos(turn) * b - std::sin(turn) * a).normalized());
    }
    add_ribbon(
        cut, spine, across, style, static_cast<std::size_t>(i) + 7919,
        [](std::size_t k) { return static_cast<double>(k) / (kJoints - 1); }, [](double) { return 3.5; },
        [&](double) { return brightness * mix(0.4, 1.0, (radius - 17) / 4); });
  }
}

Haircut cut_hair(HairStyle name) {
  Haircut cut;
  if (name == HairStyle::none) return cut;
  const Style style = style_of(name);
  Random random = Random(0x6D69656EULL).fork("haircut", static_cast<std::uint64_t>(name));
  // Directions of equal area about the head's centre; the scalp has three in five of them.
  const int all = style.ribbons * 5 / 3;
  const double golden = M_PI * (3 - std::sqrt(5.0));
  std::size_t number = 0;
  for (int i = 0; i < all; ++i) {
    const double y = 1 - (2 * i + 1.0) / all, r = std::sqrt(1 - y * y);
    const double turn = golden * i + 0.35 * random.normal() / std::max(r, 0.05) / std::sqrt(all);
    // Statements apart: the order of draws is part of the result.
    const double chance = random.uniform();
    const double depth = random.uniform();
    if (y < -0.95) continue;
    const Vec3 direction(r * std::sin(turn), y, r * std::cos(turn));
    Vec3 root = scalp_point(direction);
    if (style.flow == Flow::parted && std::abs(root.x() - style.pole.x()) < kPartingMm) {
      // Close by, hair begins at the parting itself, which else would be a bald stripe.
      const double side = root.x() < style.pole.x() ? -1 : 1;
      root.x() = style.pole.x() + side * 1.2;
      root = scalp_point((root - kHeadCentre).normalized());
    }
    if (within_hairline(root) < 7.0 * (chance - 0.35)) continue;
    Random own = random.fork("ribbon", static_cast<std::uint64_t>(i));
    grow(style, cut, root, depth, number++, own);
  }
  if (style.flow == Flow::back) add_knot(style, cut, random.fork("knot"));
  return cut;
}

}  // namespace

double within_hairline(const Vec3& p) {
  const double azimuth_deg = std::abs(std::atan2(p.x(), p.z() - kAxisZ)) * 180 / M_PI;
  const double out = std::hypot(p.x(), p.z() - kAxisZ);
  const double row = p.y() > kCrownRow ? kCrownRow + 85 * std::atan2(p.y() - kCrownRow, out) : p.y();
  return row - hairline_row(azimuth_deg);
}

const Haircut& haircut(HairStyle style) {
  static std::array<std::once_flag, kHairStyleCount> made;
  static std::array<Haircut, kHairStyleCount> cuts;
  const auto i = static_cast<std::size_t>(style);
  std::call_once(made[i], [&] { cuts[i] = cut_hair(style); });
  return cuts[i];
}

}  // namespace mien::builtin_face
