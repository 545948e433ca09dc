#include "mien/builtin_face/correctives.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/identity.h"
#include "mien/builtin_face/mesh.h"

namespace mien::builtin_face {
namespace {

using face::Corrective;

/// More than any weight is: such a driver has no upper end.
constexpr float kNoEnd = 4;

/// Takes a shape's delta back where lids are, all of it at their margins.
Corrective held_lids(const Sculpt& sculpt, const face::Shape& shape, bool left,
                     std::vector<Corrective::Driver> drivers) {
  Corrective c{.drivers = std::move(drivers), .vertex = {}, .delta_m = {}};
  for (std::size_t i = 0; i < shape.vertex.size(); ++i) {
    const SculptVertex& v = sculpt.vertices[shape.vertex[i]];
    if (v.lid == 0 || (v.anchor.x() > 0) != left) continue;
    const double share = smoothstep(0.04, 0.94, std::abs(v.lid));
    if (share == 0) continue;
    c.vertex.push_back(shape.vertex[i]);
    c.delta_m.push_back(static_cast<float>(-share) * shape.delta_m[i]);
  }
  return c;
}

/// A closed lid is where the blink puts it, whatever else pulls: b + x - b x of the way, not b + x.
void add_lids(const Sculpt& sculpt, const face::Face& face, std::vector<Corrective>& out) {
  constexpr std::string_view kWithBlink[] = {"eyeSquint",    "eyeLookDown", "eyeLookUp",  "eyeLookIn",
                                             "eyeLookOut",   "eyeWide",     "mouthSmile", "cheekSquint",
                                             "mouthUpperUp", "noseSneer"};
  for (const bool left : {true, false}) {
    const std::string side = left ? "_L" : "_R";
    const std::size_t blink = face::shape_index("eyeBlink" + side);
    out.push_back(held_lids(sculpt, face.shapes[blink], left, {{blink, 1, kNoEnd}}));
    for (const std::string_view name : kWithBlink) {
      const std::size_t other = face::shape_index(std::string(name) + side);
      out.push_back(held_lids(sculpt, face.shapes[other], left, {{blink, 0, 1}, {other, 0, kNoEnd}}));
    }
  }
}

/// A corrective of the default head, mm.
struct Push {
  std::size_t a, b;  ///< Shapes.
  std::vector<std::uint32_t> vertex;
  std::vector<Vec3> from, to;
};

/// Every pair of pulls of the mouth that ends in teeth when both are full on, though neither does.
std::vector<Push> find_pushes(const Sculpt& sculpt) {
  constexpr std::string_view kPulls[] = {
      "jawForward",     "jawLeft",      "jawRight",     "mouthLeft",      "mouthRight",    "mouthDimple_L",
      "mouthDimple_R",  "mouthFrown_L", "mouthFrown_R", "mouthPress_L",   "mouthPress_R",  "mouthRollLower",
      "mouthRollUpper", "mouthSmile_L", "mouthSmile_R", "mouthStretch_L", "mouthStretch_R"};
  const face::Face face = make_builtin(without_hair({}));
  const std::size_t n = sculpt.vertices.size();
  std::vector<std::vector<Vec3>> d;
  std::vector<Vec3> teeth;  // How each moves the lower ones.
  for (const std::string_view name : kPulls) {
    const face::Shape& shape = face.shapes[face::shape_index(name)];
    d.emplace_back(n, Vec3::Zero());
    teeth.emplace_back(Vec3::Zero());
    for (std::size_t i = 0; i < shape.vertex.size(); ++i) {
      d.back()[shape.vertex[i]] = shape.delta_m[i].cast<double>() * 1000;
      if (sculpt.vertices[shape.vertex[i]].tissue == Tissue::teeth_lower)
        teeth.back() = d.back()[shape.vertex[i]];
    }
  }
  std::vector<Push> out;
  for (std::size_t a = 0; a < d.size(); ++a)
    for (std::size_t b = a + 1; b < d.size(); ++b) {
      Push push{.a = face::shape_index(kPulls[a]),
                .b = face::shape_index(kPulls[b]),
                .vertex = {},
                .from = {},
                .to = {}};
      for (std::uint32_t i = 0; i < n; ++i) {
        const SculptVertex& v = sculpt.vertices[i];
        if (!may_touch_teeth(v)) continue;
        if (d[a][i].squaredNorm() == 0 && d[b][i].squaredNorm() == 0) continue;
        const auto way_out = [&](const Vec3& by, const Vec3& of_teeth) {
          const Vec3 up = out_of_teeth(kUpperArch, true, v.p, v.p + by);
          return Vec3(up + out_of_teeth(kLowerArch, false, v.p, v.p + by + up - of_teeth));
        };
        const Vec3 both = d[a][i] + d[b][i];
        const Vec3 more = way_out(both, teeth[a] + teeth[b]);
        if (more.norm() < 0.05) continue;
        push.vertex.push_back(i);
        push.from.emplace_back(v.p + both);
        push.to.emplace_back(v.p + both + more);
      }
      if (!push.vertex.empty()) out.push_back(std::move(push));
    }
  return out;
}

void add_teeth(const Sculpt& sculpt, const BuiltinParameters& parameters, std::vector<Corrective>& out) {
  static const std::vector<Push> pushes = find_pushes(sculpt);
  const IdentityWarp warp(parameters);
  for (const Push& push : pushes) {
    Corrective c{.drivers = {{push.a, 0, kNoEnd}, {push.b, 0, kNoEnd}}, .vertex = push.vertex, .delta_m = {}};
    for (std::size_t i = 0; i < push.vertex.size(); ++i)
      c.delta_m.push_back(((warp(push.to[i]) - warp(push.from[i])) / 1000).cast<float>());
    out.push_back(std::move(c));
  }
}

}  // namespace

std::vector<Corrective> make_correctives(const face::Face& face, const BuiltinParameters& parameters) {
  std::vector<Corrective> out;
  add_lids(default_sculpt(), face, out);
  add_teeth(default_sculpt(), parameters, out);
  return out;
}

}  // namespace mien::builtin_face
