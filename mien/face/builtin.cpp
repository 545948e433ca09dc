#include "mien/face/builtin.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mien/face/builtin_anatomy.h"
#include "mien/face/builtin_expression.h"
#include "mien/face/builtin_identity.h"
#include "mien/face/builtin_mesh.h"

namespace mien::face {
namespace {

using namespace builtin;

struct PieceInfo {
  const char* name;
  Material material;
};
constexpr PieceInfo kPieces[kPieceCount] = {
    {"skin", Material::skin},          {"ears", Material::skin},         {"lips", Material::lips},
    {"mouth", Material::mouth_inside}, {"lids", Material::skin},         {"sclera_L", Material::sclera},
    {"iris_L", Material::iris},        {"pupil_L", Material::pupil},     {"sclera_R", Material::sclera},
    {"iris_R", Material::iris},        {"pupil_R", Material::pupil},     {"teeth_upper", Material::teeth},
    {"gums_upper", Material::gums},    {"teeth_lower", Material::teeth}, {"gums_lower", Material::gums},
    {"tongue", Material::tongue},      {"lashes", Material::lash},       {"brows", Material::hair},
    {"hair", Material::hair},
};

/// The default head, sculpted once.
struct DefaultHead {
  Sculpt sculpt;
  std::vector<std::vector<Vec3>> displacements;  // mm, by shape and vertex
  std::array<std::uint32_t, 68> landmarks{};
  std::vector<Region> regions;
};

std::array<std::uint32_t, 68> find_landmarks(const Sculpt& s) {
  // The right half's 0..8, 17..21, 27..30 and so on by their places (mm) on the left, and then mirrored.
  struct Place {
    int right, left;  // landmark numbers; equal on the midline
    Vec3 p;           // on the left half
  };
  const auto lid = [](double x, bool up) { return Vec3(x, up ? upper_lid_y(x) : lower_lid_y(x), 98); };
  const double ic = kInnerCanthusX, oc = kOuterCanthusX;
  const Place places[] = {
      {0, 16, {70, 35, 35}},
      {1, 15, {70, 14, 36}},
      {2, 14, {68, -6, 38}},
      {3, 13, {63, -28, 40}},
      {4, 12, {56, -48, 48}},
      {5, 11, {44, -62, 62}},
      {6, 10, {31, -71, 78}},
      {7, 9, {16, -77, 92}},
      {8, 8, {0, -79, 98}},
      {17, 26, {54, 53, 80}},
      {18, 25, {45, 59, 88}},
      {19, 24, {35, 61, 95}},
      {20, 23, {24, 60, 101}},
      {21, 22, {13, 57, 105}},
      {27, 27, {0, 38, 106}},
      {28, 28, {0, 27, 113}},
      {29, 29, {0, 16, 121}},
      {30, 30, {0, 4, 130}},
      {31, 35, {13, -9.5, 109}},
      {32, 34, {6.5, -11, 113}},
      {33, 33, {0, -12, 115}},
      {36, 45, {oc, kOuterCanthusY, 89}},
      {37, 44, lid(mix(oc, ic, 0.33), true)},
      {38, 43, lid(mix(oc, ic, 0.67), true)},
      {39, 42, {ic, kInnerCanthusY, 90}},
      {40, 47, lid(mix(oc, ic, 0.67), false)},
      {41, 46, lid(mix(oc, ic, 0.33), false)},
      {48, 54, {kMouthCornerX + 0.8, kMouthCornerY, 102}},
      {49, 53, {15, upper_lip_border_y(15), 110}},
      {50, 52, {6, upper_lip_border_y(6), 113}},
      {51, 51, {0, upper_lip_border_y(0), 114}},
      {59, 55, {15, lower_lip_border_y(15), 108}},
      {58, 56, {8, lower_lip_border_y(8), 111}},
      {57, 57, {0, lower_lip_border_y(0), 111}},
      {60, 64, {kMouthCornerX - 2.0, kMouthCornerY, 103}},
      {61, 63, {9.5, lip_line_y(9.5) + 0.12, 110}},
      {62, 62, {0, lip_line_y(0) + 0.12, 112}},
      {67, 65, {9.5, lip_line_y(9.5) - 0.12, 110}},
      {66, 66, {0, lip_line_y(0) - 0.12, 112}},
  };
  std::array<std::uint32_t, 68> landmarks{};
  for (const Place& place : places) {
    const bool inner_lip = place.right >= 60, eye = place.right >= 36 && place.right <= 41;
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t found = 0;
    for (std::uint32_t i = 0; i < s.vertices.size(); ++i) {
      const SculptVertex& v = s.vertices[i];
      if (v.tissue != Tissue::skin && v.tissue != Tissue::lip) continue;
      if (v.p.x() < 0 || (place.right == place.left && v.p.x() != 0)) continue;
      if (inner_lip && (v.tissue != Tissue::lip || (place.right >= 65) != (v.lip_side < 0))) continue;
      // The lips meet deep in their furrow: across and up are what counts there.
      double d = inner_lip ? std::pow(v.p.x() - place.p.x(), 2) + 16 * std::pow(v.p.y() - place.p.y(), 2)
                           : (v.p - place.p).squaredNorm();
      if (eye)
        d +=
            400 * (1 - std::max(std::abs(v.lid), 0.0)) * (place.right == 36 || place.right == 39 ? 0.0 : 1.0);
      if (d < best) {
        best = d;
        found = i;
      }
    }
    landmarks[static_cast<std::size_t>(place.left)] = found;
    landmarks[static_cast<std::size_t>(place.right)] = s.mirror[found];
  }
  return landmarks;
}

std::vector<Region> find_regions(const Sculpt& s) {
  std::vector<Region> regions;
  const auto add = [&](const std::string& name, auto&& belongs) {
    Region region{name, {}};
    for (std::uint32_t i = 0; i < s.vertices.size(); ++i)
      if (belongs(s.vertices[i])) region.vertex.push_back(i);
    regions.push_back(std::move(region));
  };
  const auto outer = [](const SculptVertex& v) {
    return v.tissue == Tissue::skin || v.tissue == Tissue::lip;
  };
  // The face from ear to ear and from the hairline to the throat.
  add("skin", [&](const SculptVertex& v) {
    return outer(v) && v.p.z() > 0 && v.p.y() < 118 && v.p.y() > -110 && (v.p.y() > -70 || v.p.z() > 30);
  });
  add("lips", [&](const SculptVertex& v) { return v.tissue == Tissue::lip; });
  add("jaw", [&](const SculptVertex& v) {
    return outer(v) && v.p.z() > 20 && v.p.y() > -95 && v.lip_side <= -0.9 && v.tissue == Tissue::skin;
  });
  add("nose", [&](const SculptVertex& v) {
    return v.tissue == Tissue::skin && v.p.z() > 90 &&
           std::abs(v.p.x()) < mix(19, 11, smoothstep(0, 30, v.p.y())) && v.p.y() > -13 && v.p.y() < 42;
  });
  add("forehead", [&](const SculptVertex& v) {
    return v.tissue == Tissue::skin && v.p.z() > 50 && v.p.y() > 63 && v.p.y() < 100;
  });
  for (const double side : {1.0, -1.0}) {
    const std::string suffix = side > 0 ? "_L" : "_R";
    const auto on_side = [side](const SculptVertex& v) { return v.p.x() * side > 0; };
    add("brow" + suffix, [&](const SculptVertex& v) {
      const double x = v.p.x() * side;
      return v.tissue == Tissue::brow ? x > 0
                                      : v.tissue == Tissue::skin && x > 9 && x < 57 && v.p.z() > 60 &&
                                            v.p.y() > 50 && v.p.y() < 64;
    });
    add("lid" + suffix, [&](const SculptVertex& v) {
      return on_side(v) && (v.tissue == Tissue::lid_inside || v.tissue == Tissue::lash ||
                            (v.tissue == Tissue::skin && std::abs(v.lid) > 0.5));
    });
    add("cheek" + suffix, [&](const SculptVertex& v) {
      const double x = v.p.x() * side;
      return v.tissue == Tissue::skin && x > 20 && v.p.z() > 30 && v.p.y() < 20 && v.p.y() > -45 &&
             v.lip_side > -0.9;
    });
    add("eye" + suffix, [&](const SculptVertex& v) { return on_side(v) && v.tissue == Tissue::eyeball; });
  }
  return regions;
}

const DefaultHead& default_head() {
  static const DefaultHead head = [] {
    DefaultHead h;
    Sculpt half;
    add_skin(half);
    add_parts(half);
    h.sculpt = mirrored(half);
    add_eyeballs(h.sculpt);
    h.displacements = shape_displacements(h.sculpt);
    tune_kinematics(h.sculpt, h.displacements);
    h.landmarks = find_landmarks(h.sculpt);
    h.regions = find_regions(h.sculpt);
    return h;
  }();
  return head;
}

}  // namespace

BuiltinParameters random_identity(Random& random) {
  BuiltinParameters p;
  for (double* value :
       {&p.head_width, &p.face_length, &p.jaw_width, &p.chin_size, &p.nose_length, &p.nose_width,
        &p.nose_bridge, &p.eye_spacing, &p.eye_size, &p.mouth_width, &p.lip_fullness, &p.cheekbones,
        &p.cheek_fullness, &p.brow_ridge, &p.brow_height, &p.forehead_height, &p.ear_size, &p.neck_width})
    *value = std::clamp(random.normal(), -2.5, 2.5);
  p.asymmetry = random.uniform(0.4, 1.6);
  p.asymmetry_seed = random.bits() | 1U;
  p.skin_tone = random.uniform(0, 1);
  // Deep skin seldom goes with fair hair.
  p.hair_tone = builtin::mix(0.85, 1.0, smoothstep(0.15, 0.6, p.skin_tone)) *
                std::pow(random.uniform(), 1 - 0.9 * smoothstep(0.1, 0.7, p.skin_tone));
  p.hair = random.chance(0.85);
  return p;
}

Face make_builtin(const BuiltinParameters& parameters) {
  const DefaultHead& head = default_head();
  Sculpt sculpt = head.sculpt;
  paint(sculpt, parameters.skin_tone, parameters.hair_tone);
  Face face;
  face.name = "builtin";
  const std::size_t n = sculpt.vertices.size();
  face.neutral_m.reserve(n);
  face.colour.reserve(n);
  const IdentityWarp warp(parameters);
  std::vector<Vec3> neutral_mm;
  neutral_mm.reserve(n);
  for (const SculptVertex& v : sculpt.vertices) {
    neutral_mm.push_back(v.tissue == Tissue::ear ? warp.ear(v.p) : warp(v.p));
    face.neutral_m.push_back((neutral_mm.back() / 1000).cast<float>());
    face.colour.push_back(v.colour);
  }
  for (std::size_t k = 0; k < kPieceCount; ++k) {
    if (!parameters.hair && k == static_cast<std::size_t>(Piece::hair)) continue;
    face.parts.push_back({kPieces[k].name, kPieces[k].material,
                          static_cast<std::uint32_t>(face.triangles.size()),
                          static_cast<std::uint32_t>(sculpt.triangles[k].size())});
    face.triangles.insert(face.triangles.end(), sculpt.triangles[k].begin(), sculpt.triangles[k].end());
  }
  for (std::size_t k = 0; k <= kShapeCount; ++k) {
    Shape shape;
    shape.name = k < kShapeCount ? std::string(kShapeNames[k]) : "tongueOut";
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec3& d = head.displacements[k][i];
      if (d.squaredNorm() < 1e-6) continue;  // under a micrometre
      shape.vertex.push_back(i);
      shape.delta_m.push_back(((warp(sculpt.vertices[i].p + d) - neutral_mm[i]) / 1000).cast<float>());
    }
    face.shapes.push_back(std::move(shape));
  }
  face.landmarks = head.landmarks;
  face.has_landmarks = true;
  face.regions = head.regions;
  face.eyes = sculpt.eyes;
  for (Eyeball& eye : face.eyes) eye.centre_m = (warp(eye.centre_m.cast<double>()) / 1000).cast<float>();
  return face;
}

std::array<BuiltinSite, 12> builtin_sites() {
  // Where the same muscles lie on this head, measured on it once.
  constexpr double kMm = 1e-3;
  const Vec3 frontalis(34.6, 71.5, 93.4), orbicularis(50.9, 23.5, 86.9), upper(43, 7, 96.5),
      lower(34.3, -19, 96.3), buccinator(39.3, -36.3, 90.2), mentalis(0, -68.4, 108.7),
      mastoid(60, -7.6, -16.4);
  const auto right = [](const Vec3& p) { return Vec3(-p.x(), p.y(), p.z()); };
  return {{{"frontalis_R", right(frontalis) * kMm},
           {"frontalis_L", frontalis * kMm},
           {"orbicularis_R", right(orbicularis) * kMm},
           {"orbicularis_L", orbicularis * kMm},
           {"zygomaticus_upper_R", right(upper) * kMm},
           {"zygomaticus_upper_L", upper * kMm},
           {"zygomaticus_lower_R", right(lower) * kMm},
           {"zygomaticus_lower_L", lower * kMm},
           {"buccinator_R", right(buccinator) * kMm},
           {"buccinator_L", buccinator * kMm},
           {"mentalis", mentalis * kMm},
           {"mastoid_L", mastoid * kMm}}};
}

}  // namespace mien::face
