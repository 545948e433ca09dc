#include "mien/face/gltf/assembly.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <utility>

#include "mien/core/smoothstep.h"
#include "mien/face/profile_map.h"

namespace mien::face::gltf {
namespace fs = std::filesystem;
namespace {

/// Whether the head looks along -Z: by where the shapes that push forward push, else by where the left ones
/// are.
bool looks_backwards(const Assembly& head, double left_minus_right) {
  double forward = 0;
  double all = 0;
  for (const std::size_t k : {shape("jawForward"), shape("mouthPucker"), shape("mouthFunnel")})
    for (const auto& [vertex, delta] : head.delta[k]) {
      forward += delta.z();
      all += delta.norm();
    }
  if (all > 0 && std::abs(forward) > 0.2 * all) return forward < 0;
  return left_minus_right < 0;
}

/// Mean distance in x between the left shapes' vertices and the right ones': positive where left is on +X.
double left_minus_right(const Assembly& head) {
  double difference = 0;
  for (std::size_t k = 0; k + 1 < kShapeCount; ++k) {
    if (!kShapeNames[k].ends_with("_L") || head.delta[k].empty() || head.delta[k + 1].empty()) continue;
    const auto mean_x = [&](std::size_t shape_index) {
      double sum = 0;
      double weight = 0;
      for (const auto& [vertex, delta] : head.delta[shape_index]) {
        sum += delta.norm() * head.position[vertex].x();
        weight += delta.norm();
      }
      return weight > 0 ? sum / weight : 0.0;
    };
    difference += mean_x(k) - mean_x(k + 1);
  }
  return difference;
}

/// The unit in which the moving part of the face is as large as a person's, from brow to chin and cheek to
/// cheek.
double guess_unit(double extent) {
  constexpr double kPerson = 0.19;  // ICT's: 0.17 to 0.2 m; drawn characters keep within a factor of 2.2.
  for (const double unit : {1.0, 0.01, 0.001, 0.0254})
    if (const double size = extent * unit; size > kPerson / 2.2 && size < kPerson * 2.2) return unit;
  return 0.2 / extent;
}

}  // namespace

Result<GltfHead> finish(Assembly head, const Binding& binding, const std::string& name) {
  GltfHead result;
  Face& face = result.face;
  face.name = fs::path(name).stem().string();

  // What really moves, by at least a hundredth of the farthest: stray vertices say nothing about size.
  double peak = 0;
  for (const auto& shape_delta : head.delta)
    for (const auto& [vertex, delta] : shape_delta) peak = std::max(peak, delta.norm());
  Eigen::AlignedBox3d moving;
  for (const auto& shape_delta : head.delta)
    for (const auto& [vertex, delta] : shape_delta)
      if (delta.norm() > 0.01 * peak) moving.extend(head.position[vertex]);
  const double extent = moving.isEmpty() ? 0.0 : moving.sizes().maxCoeff();
  if (!(extent > 1e-9) || !(peak > 0)) return fail(ErrorCode::malformed, "its shapes move nothing", name);
  const double unit = guess_unit(extent);
  result.metres_per_unit = unit;
  if (unit != 1.0)
    result.warnings.push_back(
        fmt::format("one unit of the file is taken as {:.4g} m, by the size of the face", unit));

  const double sides = left_minus_right(head);
  const bool backwards = looks_backwards(head, sides);
  if ((backwards ? -sides : sides) < 0)
    result.warnings.push_back(
        "its left shapes lie on the performer's right: the names seem to be the viewer's");
  const double turn = backwards ? -1 : 1;  // Half a turn about +Y.
  const auto metres = [&](const Vec3& v) -> Vec3 { return unit * Vec3(turn * v.x(), v.y(), turn * v.z()); };
  const Vec3 middle = metres(moving.center());

  for (const Vec3& v : head.position) face.neutral_m.push_back(metres(v).cast<float>());
  face.triangles = std::move(head.triangles);
  face.parts = std::move(head.parts);
  if (head.has_uv) face.uv = std::move(head.uv);
  if (head.has_colour) face.colour = std::move(head.colour);

  constexpr double kRamp_m = 0.02;
  for (std::size_t k = 0; k <= kShapeCount; ++k) {
    if (k == kShapeCount && head.delta[k].empty()) break;
    Shape& s = face.shapes.emplace_back();
    s.name = inner_name(k);
    const double side = s.name.ends_with("_L") ? 1 : -1;
    for (const auto& [vertex, delta] : head.delta[k]) {
      double share = 1;
      if (binding.split[k]) {
        const double x = metres(head.position[vertex]).x() - middle.x();
        share = smoothstep(0.5 + 0.5 * side * x / kRamp_m);
      }
      if (share == 0) continue;
      s.vertex.push_back(vertex);
      s.delta_m.push_back((share * metres(delta)).cast<float>());
    }
    if (s.vertex.empty()) result.missing.push_back(s.name);
  }

  Region skin{"skin", {}};
  for (std::uint32_t v = 0; v < head.skin.size(); ++v)
    if (head.skin[v]) skin.vertex.push_back(v);
  if (skin.vertex.empty()) {
    // No mesh is called skin or the like: what moves is.
    std::set<std::uint32_t> moved;
    for (const Shape& s : face.shapes) moved.insert(s.vertex.begin(), s.vertex.end());
    skin.vertex.assign(moved.begin(), moved.end());
  }
  face.regions.push_back(std::move(skin));

  // Whose eye it is shows in where it is: files name them by either point of view.
  for (const Assembly::Eye& eye : head.eyes) {
    Eigen::AlignedBox3f box;
    for (std::uint32_t v = eye.first; v < eye.first + eye.count; ++v) box.extend(face.neutral_m[v]);
    const Vec3f centre = eye.pivot ? Vec3f(metres(*eye.pivot).cast<float>()) : Vec3f(box.center());
    const float offset = box.center().x() - static_cast<float>(middle.x());
    if (std::abs(offset) < 0.005F) continue;  // Both eyes in one mesh: they cannot turn apart.
    Eyeball& ball = face.eyes[offset > 0 ? 0 : 1];
    if (ball.vertex_count < eye.count) ball = {eye.first, eye.count, centre};
  }
  if (!result.missing.empty())
    result.warnings.push_back(
        fmt::format("{} shapes are missing: {}", result.missing.size(), fmt::join(result.missing, ", ")));
  return result;
}

}  // namespace mien::face::gltf
