#include "tests/builtin_face/contact.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace mien::builtin_face {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr double kMm = 1000;

std::vector<Triangle> part(const face::Face& face, std::string_view name) {
  for (const face::Part& p : face.parts)
    if (p.name == name)
      return {face.triangles.begin() + p.first_triangle,
              face.triangles.begin() + p.first_triangle + p.triangle_count};
  return {};
}
void append(std::vector<Triangle>& to, const std::vector<Triangle>& more) {
  to.insert(to.end(), more.begin(), more.end());
}
std::vector<std::uint32_t> corners(std::span<const Triangle> triangles) {
  std::set<std::uint32_t> all;
  for (const Triangle& t : triangles) all.insert(t.begin(), t.end());
  return {all.begin(), all.end()};
}

struct Hit {
  float distance;
  bool from_behind;  ///< The ray leaves the body whose surface this is.
};
/// Where a ray meets a triangle (Moeller and Trumbore 1997), beyond `least`.
std::optional<Hit> meet(const Vec3f& origin, const Vec3f& direction, std::span<const Vec3f> v,
                        const Triangle& t, float least = 0) {
  const Vec3f e1 = v[t[1]] - v[t[0]], e2 = v[t[2]] - v[t[0]];
  const Vec3f cross = direction.cross(e2);
  const float det = e1.dot(cross);
  if (std::abs(det) < 1e-14F) return {};
  const Vec3f s = origin - v[t[0]];
  const float u = s.dot(cross) / det;
  if (u < 0 || u > 1) return {};
  const Vec3f q = s.cross(e1);
  const float w = direction.dot(q) / det;
  if (w < 0 || u + w > 1) return {};
  const float distance = e2.dot(q) / det;
  if (distance <= least) return {};
  return Hit{distance, det < 0};
}

/// Triangles that hang together.
std::vector<std::vector<Triangle>> components(const std::vector<Triangle>& triangles) {
  std::map<std::uint32_t, std::uint32_t> root;
  const auto find = [&](std::uint32_t a) {
    root.try_emplace(a, a);
    while (root[a] != a) a = root[a];
    return a;
  };
  for (const Triangle& t : triangles) {
    const std::uint32_t a = find(t[0]);
    root[find(t[1])] = a;
    root[find(t[2])] = a;
  }
  std::map<std::uint32_t, std::vector<Triangle>> groups;
  for (const Triangle& t : triangles) groups[find(t[0])].push_back(t);
  std::vector<std::vector<Triangle>> out;
  for (auto& [_, group] : groups) out.push_back(std::move(group));
  return out;
}

/// Closes the one hole of a tooth, which the gum covers.
std::vector<Triangle> closed(std::vector<Triangle> triangles) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.emplace(t[k], t[(k + 1) % 3]);
  std::optional<std::uint32_t> apex;
  for (const auto& [a, b] : edges) {
    if (edges.contains({b, a})) continue;
    if (!apex) apex = a;
    if (a != *apex && b != *apex) triangles.push_back({*apex, b, a});
  }
  return triangles;
}

/// Directions spread over the sphere: how deep a point lies is the shortest way out along them.
const std::vector<Vec3f>& directions() {
  static const std::vector<Vec3f> all = [] {
    std::vector<Vec3f> out;
    constexpr int kCount = 60;
    for (int i = 0; i < kCount; ++i) {
      const float z = 1 - 2 * (static_cast<float>(i) + 0.5F) / kCount, a = 2.39996F * static_cast<float>(i);
      const float r = std::sqrt(1 - z * z);
      out.emplace_back(r * std::cos(a), r * std::sin(a), z);
    }
    return out;
  }();
  return all;
}

}  // namespace

std::string_view contact_name(Contact contact) {
  constexpr std::string_view names[] = {"skin in eyeball", "skin in teeth", "tongue in teeth",
                                        "lip in lip",      "lid over lid",  "inverted triangles"};
  return names[static_cast<std::size_t>(contact)];
}

ContactFinder::ContactFinder(const face::Face& face) : face_(face) {
  const std::vector<Triangle> skin = part(face, "skin"), lips = part(face, "lips"),
                              mouth = part(face, "mouth"), lids = part(face, "lids");
  surface_ = lips;
  // What lies under the shirt is not seen.
  std::ranges::copy_if(skin, std::back_inserter(surface_),
                       [&](const Triangle& t) { return face.neutral_m[t[0]].y() > -0.13F; });
  const auto& home = face.neutral_m;
  for (std::size_t e = 0; e < 2; ++e) {
    const std::string side = e == 0 ? "_L" : "_R";
    for (const char* name : {"sclera", "iris", "pupil"})
      append(eyeballs_[e].triangles, part(face, name + side));
    const Vec3f& centre = face.eyes[e].centre_m;
    for (const std::uint32_t i : corners(skin))
      if ((home[i] - centre).norm() < 0.025F) about_eye_[e].push_back(i);
  }
  for (const char* name : {"teeth_upper", "teeth_lower"})
    for (std::vector<Triangle>& tooth : components(part(face, name))) {
      const std::vector<std::uint32_t> own = corners(tooth);
      teeth_.push_back({closed(std::move(tooth)), own});
    }
  tongue_ = corners(part(face, "tongue"));

  // Who goes with the jaw is lower lip.
  const face::Shape& jaw = *face.find_shape("jawOpen");
  std::vector<float> drop(home.size(), 0);
  for (std::size_t i = 0; i < jaw.vertex.size(); ++i) drop[jaw.vertex[i]] = -jaw.delta_m[i].y();
  const float full = drop[face.landmarks[66]];
  std::vector<Triangle> red = lips;
  append(red, mouth);
  for (const Triangle& t : red) {
    const float mean = (drop[t[0]] + drop[t[1]] + drop[t[2]]) / (3 * full);
    if (mean < 0.3F) lips_[0].push_back(t);
    if (mean > 0.7F) lips_[1].push_back(t);
  }
  for (std::size_t s = 0; s < 2; ++s)
    for (const std::uint32_t i : corners(lips_[s]))
      if (home[i].z() > home[face.landmarks[66]].z() - 0.012F) lip_rows_[s].push_back(i);
  std::vector<Triangle> around = red;
  for (const Triangle& t : skin)
    if ((home[t[0]] - home[face.landmarks[66]]).norm() < 0.045F) around.push_back(t);
  about_mouth_ = corners(around);

  // A sliver in each corner of the mouth is turned at rest already.
  const std::vector<bool> at_rest = inverted(home);
  std::vector<Triangle> upright;
  for (std::size_t i = 0; i < surface_.size(); ++i)
    if (!at_rest[i]) upright.push_back(surface_[i]);
  surface_ = std::move(upright);

  // A lid's margin is where its skin ends. Who goes down in a blink is the upper one.
  const std::vector<std::uint32_t> outside = corners(skin), inside = corners(lids);
  std::vector<std::uint32_t> margin;
  std::ranges::set_intersection(outside, inside, std::back_inserter(margin));
  for (std::size_t e = 0; e < 2; ++e) {
    const face::Shape& blink = *face.find_shape(e == 0 ? "eyeBlink_L" : "eyeBlink_R");
    for (std::size_t i = 0; i < blink.vertex.size(); ++i) {
      if (!std::ranges::binary_search(margin, blink.vertex[i])) continue;
      const float y = blink.delta_m[i].y();
      if (std::abs(y) > 2e-4F) margin_[e][y < 0 ? 0 : 1].push_back(blink.vertex[i]);
    }
  }
}

Contacts ContactFinder::find(std::span<const Vec3f> v) const {
  Contacts out{};
  const auto set = [&](Contact c, double value) { out[static_cast<std::size_t>(c)] = value; };
  set(Contact::skin_eyeball, deepest_in_eyeballs(v));
  set(Contact::skin_teeth, deepest_in_teeth(v, about_mouth_));
  set(Contact::tongue_teeth, deepest_in_teeth(v, tongue_));
  set(Contact::lip_lip, deepest_lip(v));
  set(Contact::lid_lid, deepest_lid(v));
  set(Contact::inverted, static_cast<double>(std::ranges::count(inverted(v), true)));
  return out;
}

double ContactFinder::deepest_in_eyeballs(std::span<const Vec3f> v) const {
  double deepest = 0;
  for (std::size_t e = 0; e < 2; ++e) {
    const face::Eyeball& eye = face_.eyes[e];
    float largest = 0;
    for (std::uint32_t i = 0; i < eye.vertex_count; ++i)
      largest = std::max(largest, (v[eye.first_vertex + i] - eye.centre_m).norm());
    for (const std::uint32_t i : about_eye_[e]) {
      const Vec3f arm = v[i] - eye.centre_m;
      if (arm.norm() >= largest) continue;
      for (const Triangle& t : eyeballs_[e].triangles)
        if (const auto hit = meet(eye.centre_m, arm.normalized(), v, t))
          deepest = std::max(deepest, (hit->distance - arm.norm()) * kMm);
    }
  }
  return deepest;
}

double ContactFinder::deepest_in_teeth(std::span<const Vec3f> v, std::span<const std::uint32_t> who) const {
  double deepest = 0;
  for (const Body& tooth : teeth_) {
    Vec3f low = v[tooth.vertices[0]], high = low;
    for (const std::uint32_t i : tooth.vertices) low = low.cwiseMin(v[i]), high = high.cwiseMax(v[i]);
    for (const std::uint32_t i : who) {
      if ((v[i].array() < low.array()).any() || (v[i].array() > high.array()).any()) continue;
      float way_out = std::numeric_limits<float>::infinity();
      int inside = 0;
      for (const Vec3f& d : directions()) {
        std::optional<Hit> first;
        for (const Triangle& t : tooth.triangles)
          if (const auto hit = meet(v[i], d, v, t); hit && (!first || hit->distance < first->distance))
            first = hit;
        if (!first) continue;
        inside += first->from_behind ? 1 : -1;
        if (first->from_behind) way_out = std::min(way_out, first->distance);
      }
      if (inside > static_cast<int>(directions().size()) / 2) deepest = std::max(deepest, way_out * kMm);
    }
  }
  return deepest;
}

double ContactFinder::deepest_lip(std::span<const Vec3f> v) const {
  std::vector<Vec3f> normals(v.size());
  face::vertex_normals(face_, v, normals);
  double deepest = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    // The other lip by columns across the mouth.
    constexpr float kWide = 0.002F, kFrom = -0.05F;
    constexpr std::size_t kColumns = 50;
    std::array<std::vector<const Triangle*>, kColumns> columns;
    const auto column = [&](float x) {
      return static_cast<std::size_t>(std::clamp((x - kFrom) / kWide, 0.0F, kColumns - 1.0F));
    };
    for (const Triangle& t : lips_[1 - s]) {
      const auto [low, high] = std::minmax({v[t[0]].x(), v[t[1]].x(), v[t[2]].x()});
      for (std::size_t c = column(low); c <= column(high); ++c) columns[c].push_back(&t);
    }
    for (const std::uint32_t i : lip_rows_[s]) {
      // Along the normal, but across the columns not at all.
      const Vec3f d = Vec3f(0, normals[i].y(), normals[i].z()).normalized();
      std::array<std::optional<Hit>, 2> first;
      for (const Triangle* t : columns[column(v[i].x())])
        for (std::size_t k = 0; k < 2; ++k)
          if (const auto hit = meet(v[i], k == 0 ? d : Vec3f(-d), v, *t);
              hit && (!first[k] || hit->distance < first[k]->distance))
            first[k] = hit;
      if (!first[0] || !first[0]->from_behind || first[0]->distance > 0.012F) continue;
      if (!first[1] || !first[1]->from_behind) continue;
      deepest = std::max(deepest, std::min(first[0]->distance, first[1]->distance) * kMm);
    }
  }
  return deepest;
}

double ContactFinder::deepest_lid(std::span<const Vec3f> v) const {
  double deepest = 0;
  for (std::size_t e = 0; e < 2; ++e) {
    const Vec3f& centre = face_.eyes[e].centre_m;
    struct Direction {
      float azimuth, elevation, radius;
    };
    const auto seen = [&](std::uint32_t i) {
      const Vec3f p = v[i] - centre;
      return Direction{std::atan2(p.x(), p.z()), std::atan2(p.y(), std::hypot(p.x(), p.z())), p.norm()};
    };
    std::vector<Direction> lower;
    for (const std::uint32_t i : margin_[e][1]) lower.push_back(seen(i));
    std::ranges::sort(lower, {}, &Direction::azimuth);
    for (const std::uint32_t i : margin_[e][0]) {
      const Direction up = seen(i);
      const auto after = std::ranges::lower_bound(lower, up.azimuth, {}, &Direction::azimuth);
      if (after == lower.begin() || after == lower.end()) continue;
      const auto before = after - 1;
      const float s = (up.azimuth - before->azimuth) / std::max(after->azimuth - before->azimuth, 1e-9F);
      const float low = before->elevation + s * (after->elevation - before->elevation);
      deepest = std::max(deepest, (low - up.elevation) * up.radius * kMm);
    }
  }
  return deepest;
}

std::vector<bool> ContactFinder::inverted(std::span<const Vec3f> v) const {
  std::vector<Vec3f> sum(v.size(), Vec3f::Zero());
  std::vector<Vec3f> own(surface_.size());
  for (std::size_t i = 0; i < surface_.size(); ++i) {
    const Triangle& t = surface_[i];
    own[i] = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
    for (const std::uint32_t k : t) sum[k] += own[i];
  }
  std::vector<bool> out(surface_.size());
  for (std::size_t i = 0; i < surface_.size(); ++i) {
    const Triangle& t = surface_[i];
    // Slivers of under a fiftieth of a square millimetre, as in the corner of the mouth, have no face to
    // speak of.
    out[i] = own[i].norm() > 4e-8F && own[i].dot(sum[t[0]] + sum[t[1]] + sum[t[2]] - 3 * own[i]) < 0;
  }
  return out;
}

}  // namespace mien::builtin_face
