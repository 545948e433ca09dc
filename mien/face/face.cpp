#include "mien/face/face.h"

#include <algorithm>
#include <array>

#include "mien/face/normals.h"

namespace mien::face {

const Region* Face::region(std::string_view region_name) const {
  const auto found = std::ranges::find(regions, region_name, &Region::name);
  return found == regions.end() ? nullptr : &*found;
}

const Shape* Face::find_shape(std::string_view shape_name) const {
  const auto found = std::ranges::find(shapes, shape_name, &Shape::name);
  return found == shapes.end() ? nullptr : &*found;
}

std::string_view material_name(Material material) {
  constexpr std::array<std::string_view, 15> kNames = {"skin",    "lips",  "sclera",       "iris",   "pupil",
                                                       "cornea",  "teeth", "gums",         "tongue", "hair",
                                                       "strands", "lash",  "mouth_inside", "cloth",  "other"};
  static_assert(kNames.size() == static_cast<std::size_t>(Material::other) + 1);
  return kNames.at(static_cast<std::size_t>(material));
}

std::vector<bool> Face::vertices_of(Material material) const {
  std::vector<bool> used(neutral_m.size(), false);
  for (const Part& part : parts) {
    if (part.material != material) continue;
    const std::size_t end =
        std::min(triangles.size(), std::size_t{part.first_triangle} + part.triangle_count);
    for (std::size_t t = part.first_triangle; t < end; ++t)
      for (const std::uint32_t i : triangles[t]) used[i] = true;
  }
  return used;
}

void evaluate(const Face& face, const BlendshapeWeights& weights, float tongue_out,
              std::span<Vec3f> vertices_m) {
  eigen_assert(vertices_m.size() == face.neutral_m.size());
  std::ranges::copy(face.neutral_m, vertices_m.begin());
  for (std::size_t k = 0; k < face.shapes.size(); ++k) {
    const float w = k < kShapeCount ? weights[k] : tongue_out;
    if (w == 0) continue;
    const Shape& s = face.shapes[k];
    for (std::size_t i = 0; i < s.vertex.size(); ++i) vertices_m[s.vertex[i]] += w * s.delta_m[i];
  }
}

std::array<Eigen::Vector2f, 2> eyes_rad(const BlendshapeWeights& weights) {
  constexpr auto kRadPerUnit = static_cast<float>(kEyeTurnRadPerUnit);
  const auto difference = [&](std::size_t more, std::size_t less) {
    return kRadPerUnit * (weights[more] - weights[less]);
  };
  return {Eigen::Vector2f(difference(shape("eyeLookOut_L"), shape("eyeLookIn_L")),
                          difference(shape("eyeLookUp_L"), shape("eyeLookDown_L"))),
          Eigen::Vector2f(difference(shape("eyeLookIn_R"), shape("eyeLookOut_R")),
                          difference(shape("eyeLookUp_R"), shape("eyeLookDown_R")))};
}

void turn_eyes(const Face& face, const BlendshapeWeights& weights, std::span<Vec3f> vertices_m) {
  const std::array<Eigen::Vector2f, 2> angles_rad = eyes_rad(weights);
  for (std::size_t e = 0; e < 2; ++e) {
    const Eyeball& eye = face.eyes[e];
    // +X is the performer's left and +Z forward: a positive turn about +Y looks left, about -X looks up.
    const Eigen::Matrix3f turn = (Eigen::AngleAxisf(angles_rad[e].x(), Vec3f::UnitY()) *
                                  Eigen::AngleAxisf(-angles_rad[e].y(), Vec3f::UnitX()))
                                     .toRotationMatrix();
    for (std::uint32_t i = eye.first_vertex; i < eye.first_vertex + eye.vertex_count; ++i)
      vertices_m[i] = eye.centre_m + turn * (vertices_m[i] - eye.centre_m);
  }
}

void vertex_normals(const Face& face, std::span<const Vec3f> vertices_m, std::span<Vec3f> normals) {
  std::ranges::fill(normals, Vec3f::Zero());
  for (const auto& [a, b, c] : face.triangles) {
    const std::array<Vec3f, 3> corner = corner_normals(vertices_m[a], vertices_m[b], vertices_m[c]);
    normals[a] += corner[0];
    normals[b] += corner[1];
    normals[c] += corner[2];
  }
  for (Vec3f& n : normals) {
    const float length = n.norm();
    n = length > 0 ? Vec3f(n / length) : Vec3f::UnitZ();
  }
}

float peak_displacement_m(const Face& face, std::string_view shape_name) {
  const Shape* s = face.find_shape(shape_name);
  float peak = 0;
  if (s != nullptr)
    for (const Vec3f& d : s->delta_m) peak = std::max(peak, d.norm());
  return peak;
}

}  // namespace mien::face
