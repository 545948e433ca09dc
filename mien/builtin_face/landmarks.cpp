#include "mien/builtin_face/mesh.h"

#include <cmath>
#include <limits>
#include <string>

#include "mien/builtin_face/anatomy.h"

namespace mien::builtin_face {

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

std::vector<face::Region> find_regions(const Sculpt& s) {
  std::vector<face::Region> regions;
  const auto add = [&](const std::string& name, auto&& belongs) {
    face::Region region{name, {}};
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

}  // namespace mien::builtin_face
