#include "lab/imu/placement/sensor_candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/haircut.h"
#include "mien/core/excerpt.h"
#include "mien/core/units.h"
#include "mien/face/surface_point.h"

namespace mien::lab {
namespace {

constexpr double kSameSiteM = 0.003;
constexpr double kOffSkinM = 0.010;
/// A place a little inside is a rounded one, or of a head that is a little larger.
constexpr double kInsideM = 0.003;
/// Half a module.
constexpr double kFreeM = kModuleApartM / 2;
constexpr double kSampleM = 0.0015;  // Places that the grid chooses from.

Vec3 vertex_m(const face::Face& face, std::uint32_t v) {
  return face.neutral_m[v].cast<double>();
}

/// Parts of the built-in head that nothing is glued on or beside.
bool is_kept_free(const std::string& part) {
  return part == "lips" || part == "lids" || part == "ears" || part == "brows" || part == "lashes" ||
         part == "sclera_L" || part == "sclera_R";
}

/// Triangles that face outwards: not the insides of lids and mouth.
std::vector<std::uint32_t> outer_triangles(const face::Face& face) {
  std::vector<std::uint32_t> triangles;
  for (const face::Part& part : face.parts)
    if (part.name == "skin" || part.name == "lips" || part.name == "ears")
      for (std::uint32_t t = 0; t < part.triangle_count; ++t) triangles.push_back(part.first_triangle + t);
  return triangles;
}

/// Height of the jaw's edge, where the landmarks of the face's outline are (builtin_face), mm.
double jaw_edge_y(double aside) {
  constexpr std::array<std::array<double, 2>, 6> kEdge = {
      {{0, -79}, {16, -77}, {31, -71}, {44, -62}, {56, -48}, {63, -28}}};
  for (std::size_t i = 0; i + 1 < kEdge.size(); ++i)
    if (aside < kEdge[i + 1][0])
      return kEdge[i][1] +
             (kEdge[i + 1][1] - kEdge[i][1]) * (aside - kEdge[i][0]) / (kEdge[i + 1][0] - kEdge[i][0]);
  return kEdge.back()[1];
}

/// Whether skin here can carry a module, but for what stands beside it. Measures of the default head, mm.
bool is_glueable(const Vec3& p_m, const Vec3& normal) {
  const Vec3 p = kMmPerM * p_m;
  const double aside = std::abs(p.x());
  if (p.z() < 30 || p.y() < jaw_edge_y(aside) || normal.z() < -0.1) return false;  // Back, neck.
  if (p.y() < -45 && normal.y() < -0.6) return false;                              // Below the jaw.
  if (builtin_face::within_hairline(p) > -kMmPerM * kFreeM) return false;          // Hair.
  const double across = (aside - 32) / 23, up = (p.y() - 38) / (p.y() > 38 ? 17 : 13);
  if (p.z() > 60 && across * across + up * up < 1) return false;  // Lids, up to brow and socket's edge.
  const bool nose = aside < 20 && p.z() > 96 && p.y() > -18 && p.y() < 12;
  if (nose && (normal.y() < -0.25 || normal.z() < 0.15)) return false;  // Nostrils, alae's edge.
  return true;
}

/// The part of the face, by place on the default head, mm.
const char* area_of(const Vec3& p_m) {
  const Vec3 p = kMmPerM * p_m;
  const double aside = std::abs(p.x());
  if (p.y() > 58) return aside > 56 ? "temple" : "forehead";
  if (aside < 12 && p.y() > 38) return "glabella";
  if (aside < 19 && p.y() > -13) return "nose";
  if (p.y() > 18) return aside > 58 ? "temple" : "eye";
  if (p.y() > -16) return "cheek";
  if (p.y() > -52) return aside < 32 ? "mouth" : aside < 56 ? "cheek" : "jaw";
  return aside < 24 ? "chin" : "jaw";
}

struct PlacementSample {
  Vec3 position_m, normal;
};

/// Dense places on the right half (x <= 0) and the midline, in the mesh's order.
std::vector<PlacementSample> glueable_samples(const face::Face& face) {
  std::vector<Vec3> kept_free_m;
  for (const face::Part& part : face.parts) {
    if (!is_kept_free(part.name)) continue;
    for (std::uint32_t t = 0; t < part.triangle_count; ++t)
      for (const std::uint32_t v : face.triangles[part.first_triangle + t]) {
        if (vertex_m(face, v).x() < 0.01) kept_free_m.push_back(vertex_m(face, v));
      }
  }
  if (const face::Region* lid = face.region("lid_R"); lid != nullptr)
    for (const std::uint32_t v : lid->vertex) kept_free_m.push_back(vertex_m(face, v));
  // Places beside what is kept free are found by cells of its reach.
  const auto cell_of = [](const Vec3& p) {
    return std::array<int, 3>{static_cast<int>(std::floor(p.x() / kFreeM)),
                              static_cast<int>(std::floor(p.y() / kFreeM)),
                              static_cast<int>(std::floor(p.z() / kFreeM))};
  };
  std::map<std::array<int, 3>, std::vector<Vec3>> cells;
  for (const Vec3& p : kept_free_m) cells[cell_of(p)].push_back(p);
  const auto is_free = [&](const Vec3& p) {
    const std::array<int, 3> at = cell_of(p);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto found = cells.find({at[0] + x, at[1] + y, at[2] + z});
          if (found == cells.end()) continue;
          for (const Vec3& kept : found->second)
            if ((kept - p).norm() < kFreeM) return false;
        }
    return true;
  };

  std::vector<PlacementSample> samples;
  for (const face::Part& part : face.parts) {
    if (part.name != "skin") continue;
    for (std::uint32_t t = 0; t < part.triangle_count; ++t) {
      const auto& corner = face.triangles[part.first_triangle + t];
      const Vec3 a = vertex_m(face, corner[0]), b = vertex_m(face, corner[1]), c = vertex_m(face, corner[2]);
      if (a.x() > 1e-6 || b.x() > 1e-6 || c.x() > 1e-6) continue;
      const Vec3 normal = (b - a).cross(c - a).normalized();
      const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
      const int steps = std::max(1, static_cast<int>(std::ceil(longest / kSampleM)));
      for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps; ++j) {
          const Vec3 p = a + (b - a) * i / steps + (c - a) * j / steps;
          if (is_glueable(p, normal) && is_free(p)) samples.push_back({p, normal});
        }
    }
  }
  return samples;
}

/// Numbered by area, from above to below.
void name_candidates(std::vector<SensorCandidate>& half) {
  std::ranges::stable_sort(half, [](const SensorCandidate& a, const SensorCandidate& b) {
    return a.position_m.y() != b.position_m.y() ? a.position_m.y() > b.position_m.y()
                                                : a.position_m.x() > b.position_m.x();
  });
  std::map<std::string, int> count;
  for (SensorCandidate& candidate : half)
    candidate.name = fmt::format("{}_{:02}", candidate.area, ++count[candidate.area]);
}

/// The mount's site on the built-in head.
std::optional<Vec3> site_of_mount(const sensor::Mount& mount) {
  if (mount.position_m) return mount.position_m;
  for (const builtin_face::BuiltinSite& site : builtin_face::builtin_sites())
    if (site.name == mount.name) return site.position_m;
  return std::nullopt;
}

/// On the skin, and not inside the head.
Result<void> check_on_skin(const face::Face& face, const std::vector<std::uint32_t>& triangles,
                           const sensor::Mount& mount, const Vec3& position_m, const std::string& where) {
  const face::SurfacePoint nearest = face::nearest_on_skin(face, triangles, position_m);
  const Vec3 a = vertex_m(face, nearest.vertex[0]);
  const Vec3 normal =
      (vertex_m(face, nearest.vertex[1]) - a).cross(vertex_m(face, nearest.vertex[2]) - a).normalized();
  const Vec3 away = position_m - face::neutral_position(face, nearest);
  const bool inside = away.dot(normal) < 0;
  if (away.norm() <= (inside ? kInsideM : kOffSkinM)) return {};
  return fail(ErrorCode::out_of_range,
              fmt::format("sensor {} is {:.0f} mm {}", excerpt(mount.name), kMmPerM * away.norm(),
                          inside ? "inside the head" : "off the skin"),
              where, "give a position_m on the built-in head's skin, in metres (docs/reference/frames.md)");
}

}  // namespace

std::vector<SensorCandidate> dense_candidates(double spacing_m) {
  const face::Face& face = builtin_face::default_builtin();
  const std::vector<PlacementSample> samples = glueable_samples(face);
  std::vector<double> nearest_m(samples.size(), 1.0);
  const auto take = [&](const Vec3& p) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      nearest_m[i] = std::min(nearest_m[i], (samples[i].position_m - p).norm());
  };
  std::vector<SensorCandidate> middle, half;
  // The midline, from above; what remains in the middle of it is less than a spacing apart.
  std::vector<Vec3> line;
  for (const PlacementSample& sample : samples)
    if (std::abs(sample.position_m.x()) < 1e-6) line.push_back(sample.position_m);
  std::ranges::stable_sort(line, [](const Vec3& a, const Vec3& b) { return a.y() > b.y(); });
  for (const Vec3& p : line) {
    const bool near = std::ranges::any_of(
        middle, [&](const SensorCandidate& other) { return (other.position_m - p).norm() < spacing_m; });
    if (near) continue;
    middle.push_back({.name = {}, .area = area_of(p), .side = 'M', .position_m = Vec3(0, p.y(), p.z())});
    take(p);
  }
  // Then the place that is farthest from all, again and again (Gonzalez 1985,
  // doi:10.1016/0304-3975(85)90224-5); what lies too close to its own mirror image is none.
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (std::abs(samples[i].position_m.x()) < spacing_m / 2) nearest_m[i] = 0;
  while (!samples.empty()) {
    const auto farthest = std::ranges::max_element(nearest_m);
    if (*farthest < spacing_m) break;
    const Vec3 p = samples[static_cast<std::size_t>(farthest - nearest_m.begin())].position_m;
    half.push_back({.name = {}, .area = area_of(p), .side = 'R', .position_m = p});
    take(p);
  }
  name_candidates(middle);
  name_candidates(half);
  std::vector<SensorCandidate> all;
  for (SensorCandidate& candidate : middle) {
    candidate.name += "_M";
    all.push_back(std::move(candidate));
  }
  for (const SensorCandidate& candidate : half) {
    SensorCandidate right = candidate, left = candidate;
    right.name += "_R";
    left.name += "_L";
    left.side = 'L';
    left.position_m.x() = -left.position_m.x();
    all.push_back(std::move(right));
    all.push_back(std::move(left));
  }
  return all;
}

Result<std::vector<SensorCandidate>> candidates_of(const sensor::Rig& rig) {
  const face::Face& face = builtin_face::default_builtin();
  const std::vector<std::uint32_t> triangles = outer_triangles(face);
  std::vector<SensorCandidate> candidates;
  for (const std::uint16_t s : rig.face_sensors()) {
    const sensor::Mount& mount = rig.sensors[s];
    if (mount.kind != "imu") continue;
    const std::optional<Vec3> position_m = site_of_mount(mount);
    if (!position_m)
      return fail(ErrorCode::not_found, fmt::format("nobody knows where sensor {} is", excerpt(mount.name)),
                  rig.name, "give it a position_m in the rig file");
    MIEN_TRY(check_on_skin(face, triangles, mount, *position_m, rig.name));
    for (const SensorCandidate& other : candidates)
      if ((other.position_m - *position_m).norm() < kSameSiteM)
        return fail(
            ErrorCode::bad_usage,
            fmt::format("sensors {} and {} are at the same site, {:.1f} mm apart", excerpt(other.name),
                        excerpt(mount.name), kMmPerM * (other.position_m - *position_m).norm()),
            rig.name, "remove one of them");
    candidates.push_back({.name = mount.name,
                          .area = mount.site.empty() ? mount.name : mount.site,
                          .side = mount.side,
                          .position_m = *position_m,
                          .ict_vertex = mount.ict_vertex});
  }
  if (candidates.empty())
    return fail(ErrorCode::bad_usage, "the rig has no IMU on the face", rig.name,
                "give sensors of kind \"imu\" and role \"face\"");
  return candidates;
}

sensor::Rig sites_rig(const std::vector<SensorCandidate>& candidates) {
  sensor::Rig rig{.name = "candidates",
                  .reference = candidates.empty() ? std::string() : candidates.front().name,
                  .sensors = {},
                  .skin = {},
                  .faults_toml = {}};
  for (const SensorCandidate& candidate : candidates) {
    sensor::Mount mount;
    mount.name = candidate.name;
    mount.kind = "imu";
    mount.site = candidate.area;
    mount.side = candidate.side;
    mount.role = "face";
    mount.ict_vertex = candidate.ict_vertex;
    mount.position_m = candidate.position_m;
    rig.sensors.push_back(std::move(mount));
  }
  return rig;
}

std::vector<std::size_t> mirror_candidates(const std::vector<SensorCandidate>& candidates) {
  std::vector<std::size_t> mirror(candidates.size(), candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Vec3& p = candidates[i].position_m;
    double least_m = kSameSiteM;
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      const double apart_m = (candidates[j].position_m - Vec3(-p.x(), p.y(), p.z())).norm();
      if (apart_m >= least_m) continue;
      least_m = apart_m;
      mirror[i] = j;
    }
  }
  return mirror;
}

Result<sensor::Rig> worn_rig_of(const std::vector<SensorCandidate>& candidates, const sensor::Rig& base,
                                const std::string& name, const virt::SkinMotionRequest& skin,
                                const Progress& progress) {
  const std::optional<std::uint16_t> head = base.head_sensor();
  if (!head)
    return fail(ErrorCode::not_found, "the rig has no sensor of the head to measure a face against",
                base.name, "use one such as rigs/default.toml");
  if (candidates.empty()) return fail(ErrorCode::bad_usage, "a rig needs at least one sensor on the face");
  sensor::Rig rig = sites_rig(candidates);
  rig.name = name;
  rig.sensors.push_back(base.sensors[*head]);
  rig.reference = rig.sensors.back().name;
  rig.faults_toml = base.faults_toml;
  for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
    sensor::Mount& mount = rig.sensors[s];
    mount.device = fmt::format("02:4D:49:45:4E:{:02X}", s);
    if (mount.role == "face") mount.position_m = (1e4 * *mount.position_m).array().round() / 1e4;
  }
  MIEN_TRY_ASSIGN(rig.skin, virt::study_skin_motion(skin, rig, progress));
  return rig;
}

}  // namespace mien::lab
