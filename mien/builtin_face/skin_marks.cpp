#include "mien/builtin_face/skin_marks.h"

#include <algorithm>
#include <cmath>

#include "mien/builtin_face/albedo.h"
#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/held.h"
#include "mien/builtin_face/mesh.h"
#include "mien/core/random.h"

namespace mien::builtin_face {
namespace {

/// Where the sun falls: nose and cheeks first, then brow and chin.
double sun_at(const Vec3& p) {
  const auto spot = [&](double x, double y, double rx, double ry) {
    return gauss(std::hypot((std::abs(p.x()) - x) / rx, (p.y() - y) / ry));
  };
  const double front = smoothstep(20, 60, p.z());
  return front * std::min(1.0, spot(32, 2, 24, 17) + 0.9 * spot(0, 10, 14, 20) + 0.3 * spot(0, 70, 50, 22) +
                                   0.25 * spot(0, -64, 22, 14) + 0.12);
}

std::vector<face::Mole> moles(const BuiltinParameters& q, const face::Face& face) {
  std::vector<face::Mole> out;
  if (q.asymmetry_seed == 0) return out;
  const Sculpt& sculpt = default_sculpt();
  std::vector<std::uint32_t> places;
  for (std::uint32_t i = 0; i < sculpt.vertices.size(); ++i) {
    const SculptVertex& v = sculpt.vertices[i];
    if (v.tissue == Tissue::skin && v.lid == 0 && v.p.z() > 45 && v.p.y() > -95 && v.p.y() < 80)
      places.push_back(i);
  }
  Random random = Random(q.asymmetry_seed).fork("moles");
  // Fair skin has more, and they come until middle age.
  const double most = mix(8, 4, q.skin_tone) * smoothstep(5, 45, q.age_years);
  const auto count = static_cast<int>(most * random.uniform() * random.uniform() + 0.6);
  for (int i = 0; i < count; ++i) {
    const auto place = static_cast<std::size_t>(random.uniform() * static_cast<double>(places.size()));
    out.push_back({.centre_m = face.neutral_m[places[std::min(place, places.size() - 1)]],
                   .radius_m = static_cast<float>(mix(0.6e-3, 1.5e-3, random.uniform() * random.uniform())),
                   .darkness = static_cast<float>(mix(0.45, 0.85, random.uniform()))});
  }
  return out;
}

}  // namespace

face::SkinMarks skin_marks(const BuiltinParameters& parameters, const face::Face& face) {
  const BuiltinParameters q = held(parameters);
  const double fair = smoothstep(0.42, 0.05, q.skin_tone);
  Random random = Random(q.asymmetry_seed).fork("freckles");
  const double freckled = std::clamp(
      fair * (0.10 + 1.0 * q.hair_red * (1 - 0.4 * q.hair_tone)) * mix(0.6, 1.4, random.uniform()), 0.0, 1.0);
  const Albedos albedos = visible_albedos(q);
  face::SkinMarks marks;
  marks.person = static_cast<float>(q.asymmetry_seed % 1009);
  marks.stubble = albedos.hair.cwiseMin(0.35F * albedos.skin);
  marks.moles = moles(q, face);
  marks.amount.assign(face.neutral_m.size(), Eigen::Vector2f::Zero());
  const Sculpt& sculpt = default_sculpt();
  for (std::size_t i = 0; i < sculpt.vertices.size(); ++i) {
    const SculptVertex& v = sculpt.vertices[i];
    if (v.tissue != Tissue::skin) continue;
    marks.amount[i] = {static_cast<float>(freckled * sun_at(v.p)),
                       static_cast<float>(std::clamp(q.beard, 0.0, 1.0) * beard_amount(v.p))};
  }
  return marks;
}

face::SkinFolds skin_folds(const BuiltinParameters& parameters) {
  const double age = std::clamp(parameters.age_years, 18.0, 90.0);
  const double slack = age < 45 ? mix(-0.04, 0.0, (age - 18) / 27) : mix(0.0, 0.07, (age - 45) / 45);
  return {.depth = static_cast<float>(mix(0.5, 0.85, smoothstep(25, 75, age))),
          .slack = static_cast<float>(slack)};
}

}  // namespace mien::builtin_face
