#include "mien/render/face_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "mien/face/face.h"
#include "mien/render/image.h"
#include "mien/render/parallel.h"
#include "mien/render/skin_detail.h"
#include "mien/render/tone.h"

namespace mien::render {
namespace {

using Eigen::Vector2f;
constexpr std::uint32_t kUnclaimed = 0xFFFFFFFF;

float cross(const Vector2f& a, const Vector2f& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Shares of the corners at `at`; none negative inside.
Vec3f shares(const std::array<Vector2f, 3>& uv, const Vector2f& at) {
  const float whole = cross(uv[1] - uv[0], uv[2] - uv[0]);
  const float b = cross(at - uv[0], uv[2] - uv[0]) / whole, c = cross(uv[1] - uv[0], at - uv[0]) / whole;
  return {1 - b - c, b, c};
}

/// Spreads what is known over what is not: means of ever larger squares.
void fill(std::vector<std::uint8_t>& rgb, const std::vector<std::uint8_t>& known, int side) {
  if (side <= 1) return;
  const int half = (side + 1) / 2;
  const auto at = [](int x, int y, int wide) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(wide) + static_cast<std::size_t>(x);
  };
  std::vector<std::uint8_t> small(3 * at(0, half, half)), small_known(at(0, half, half));
  for (int y = 0; y < half; ++y)
    for (int x = 0; x < half; ++x) {
      std::array<int, 3> sum{};
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const int fine_x = 2 * x + k % 2, fine_y = 2 * y + k / 2;
        if (fine_x >= side || fine_y >= side) continue;
        const std::size_t i = at(fine_x, fine_y, side);
        if (known[i] == 0) continue;
        ++count;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += rgb[3 * i + c];
      }
      if (count == 0) continue;
      small_known[at(x, y, half)] = 1;
      for (std::size_t c = 0; c < 3; ++c)
        small[3 * at(x, y, half) + c] = static_cast<std::uint8_t>(sum[c] / count);
    }
  fill(small, small_known, half);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      if (const std::size_t i = at(x, y, side); known[i] == 0)
        std::copy_n(small.begin() + std::ptrdiff_t(3 * at(x / 2, y / 2, half)), 3,
                    rgb.begin() + std::ptrdiff_t(3 * i));
}

/// Which triangle each texel shows.
Result<std::vector<std::uint32_t>> claims(const face::Face& face, const std::vector<face::Material>& material,
                                          int side) {
  const auto wide = static_cast<float>(side);
  std::vector<std::uint32_t> owner(static_cast<std::size_t>(side) * static_cast<std::size_t>(side),
                                   kUnclaimed);
  std::size_t twice = 0;
  for (std::uint32_t t = 0; t < face.triangles.size(); ++t) {
    if (!is_textured(material[t])) continue;
    const auto uv = uv_of(face, face.triangles[t]);
    for (const Vector2f& corner : uv)
      if (!corner.allFinite() || corner.minCoeff() < 0 || corner.maxCoeff() > 1)
        return fail(ErrorCode::bad_usage, "its texture coordinates leave the picture", face.name,
                    "export it with --textures none");
    // Turned over: the hidden cap behind an eyeball.
    if (!(cross(uv[1] - uv[0], uv[2] - uv[0]) < 0)) continue;
    const Vector2f low = uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]) * wide;
    const Vector2f high = uv[0].cwiseMax(uv[1]).cwiseMax(uv[2]) * wide;
    for (int y = static_cast<int>(low.y()); y <= std::min(side - 1, static_cast<int>(high.y())); ++y)
      for (int x = static_cast<int>(low.x()); x <= std::min(side - 1, static_cast<int>(high.x())); ++x) {
        const Vector2f middle(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
        const Vec3f share = shares(uv, middle / wide);
        if (share.minCoeff() < 0) continue;
        std::uint32_t& mine =
            owner[static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x)];
        if (mine != kUnclaimed) twice += share.minCoeff() > 1e-3F ? 1 : 0;
        mine = t;
      }
  }
  if (twice > owner.size() / 1000)
    return fail(ErrorCode::bad_usage, "its texture coordinates lie on each other", face.name,
                "export it with --textures none");
  return owner;
}

}  // namespace

bool is_textured(face::Material material) {
  using face::Material;
  return material == Material::skin || material == Material::lips || material == Material::sclera ||
         material == Material::iris || material == Material::pupil;
}

std::array<Vector2f, 3> uv_of(const face::Face& face, const std::array<std::uint32_t, 3>& triangle) {
  std::array<Vector2f, 3> uv;
  for (std::size_t k = 0; k < 3; ++k) uv[k] = face.uv[triangle[k]];
  const float low = std::min({uv[0].x(), uv[1].x(), uv[2].x()});
  for (Vector2f& corner : uv)
    if (corner.x() - low > 0.5F) corner.x() -= 1;
  return uv;
}

std::vector<Eigen::Vector4f> tangents_of(const face::Face& face, std::span<const Vec3f> normals) {
  std::vector<Vec3f> sum(face.neutral_m.size(), Vec3f::Zero());
  const auto material = material_of_triangles(face);
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    if (!is_textured(material[t])) continue;
    const auto& [a, b, c] = face.triangles[t];
    const auto uv = uv_of(face, face.triangles[t]);
    const Vector2f one = uv[1] - uv[0], two = uv[2] - uv[0];
    if (!(cross(one, two) < 0)) continue;
    const Vec3f along = -(two.y() * (face.neutral_m[b] - face.neutral_m[a]) -
                          one.y() * (face.neutral_m[c] - face.neutral_m[a]));
    for (const std::uint32_t i : face.triangles[t]) sum[i] += along;
  }
  std::vector<Eigen::Vector4f> out;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const Vec3f& n = normals[i];
    Vec3f along = sum[i] - sum[i].dot(n) * n;
    if (!(along.norm() > 1e-12F)) along = n.unitOrthogonal();
    along.normalize();
    out.emplace_back(along.x(), along.y(), along.z(), 1.0F);
  }
  return out;
}

Result<FaceTextures> bake_textures(const face::Face& face, const SurfacePaint& paint, int side_px,
                                   int thread_count) {
  const std::size_t vertices = face.neutral_m.size();
  const std::size_t marked = paint.marks().amount.size();
  if (face.uv.size() != vertices || (!face.colour.empty() && face.colour.size() != vertices) ||
      (marked > 0 && marked != vertices))
    return fail(ErrorCode::malformed, "texture coordinates, colours or marks do not fit the vertices",
                face.name);
  if (side_px < 1 || side_px > kLargestTexture)
    return fail(ErrorCode::out_of_range, fmt::format("a texture of {} pixels a side", side_px), face.name,
                fmt::format("give 1 to {}", kLargestTexture));
  const auto material = material_of_triangles(face);
  std::vector<Vec3f> normals(face.neutral_m.size());
  face::vertex_normals(face, face.neutral_m, normals);
  MIEN_TRY_ASSIGN(const auto owner, claims(face, material, side_px));
  const auto tangents = tangents_of(face, normals);
  FaceTextures out{.side_px = side_px, .albedo = {}, .roughness = {}, .normal = {}};
  std::vector<std::uint8_t> known(owner.size());
  for (auto* picture : {&out.albedo, &out.roughness, &out.normal}) picture->resize(3 * owner.size());
  Workers workers(thread_count > 0 ? thread_count
                                   : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  parallel(workers, owner.size(), 16384, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t t = owner[i];
      if (t == kUnclaimed) continue;
      known[i] = 1;
      const auto& triangle = face.triangles[t];
      const auto uv = uv_of(face, triangle);
      const auto wide = static_cast<std::size_t>(side_px);
      const Vector2f at = Vector2f(static_cast<float>(i % wide) + 0.5F, static_cast<float>(i / wide) + 0.5F) /
                          static_cast<float>(side_px);
      const Vec3f share = shares(uv, at);
      const auto between = [&](const auto& field) {
        return (share[0] * field[triangle[0]] + share[1] * field[triangle[1]] + share[2] * field[triangle[2]])
            .eval();
      };
      const Vec3f p = between(face.neutral_m);
      Vec3f own = Vec3f::Zero();
      if (!face.colour.empty()) own = between(face.colour);
      const float area = (face.neutral_m[triangle[1]] - face.neutral_m[triangle[0]])
                             .cross(face.neutral_m[triangle[2]] - face.neutral_m[triangle[0]])
                             .norm();
      Place place;
      place.footprint_m =
          std::sqrt(area / std::abs(cross(uv[1] - uv[0], uv[2] - uv[0]))) / static_cast<float>(side_px);
      if (!paint.marks().amount.empty()) place.marks = between(paint.marks().amount);
      const Surface s = paint.at(p, material[t], face.colour.empty() ? nullptr : &own, place);
      const Rgb albedo = to_srgb(s.albedo);
      std::ranges::copy(albedo, out.albedo.begin() + std::ptrdiff_t(3 * i));
      const auto byte = [](float x) {
        return static_cast<std::uint8_t>(255 * std::clamp(x, 0.0F, 1.0F) + 0.5F);
      };
      out.roughness[3 * i] = out.roughness[3 * i + 1] = byte(s.roughness);
      const Vec3f n = between(normals).normalized();
      const Eigen::Vector4f mean = between(tangents);
      const Vec3f along = (mean.head<3>() - mean.head<3>().dot(n) * n).normalized();
      const Vec3f rough = with_pores(n, p, s.bump, place.footprint_m);
      const Vec3f tilted(rough.dot(along), rough.dot(n.cross(along)), rough.dot(n));
      for (int c = 0; c < 3; ++c)
        out.normal[3 * i + static_cast<std::size_t>(c)] = byte(0.5F + 0.5F * tilted[c]);
    }
  });
  for (auto* picture : {&out.albedo, &out.roughness, &out.normal}) fill(*picture, known, side_px);
  return out;
}

Result<TextureFiles> bake_texture_files(const face::Face& face, const SurfacePaint& paint, int side_px,
                                        int thread_count) {
  MIEN_TRY_ASSIGN(const FaceTextures baked, bake_textures(face, paint, side_px, thread_count));
  TextureFiles files;
  // As coarse as it may be before a portrait shows it; what is smooth needs little.
  MIEN_TRY_ASSIGN(files.albedo, encode_jpeg(side_px, side_px, JpegPixels::colour, 88, baked.albedo));
  MIEN_TRY_ASSIGN(files.roughness, encode_jpeg(side_px, side_px, JpegPixels::colour, 85, baked.roughness));
  MIEN_TRY_ASSIGN(files.normal, encode_jpeg(side_px, side_px, JpegPixels::data, 60, baked.normal));
  return files;
}

}  // namespace mien::render
