#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/render/surface_paint.h"

namespace mien::render {

/// Whether pictures show this material: skin, lips and eyeballs. Other parts are of one colour each.
[[nodiscard]] bool is_textured(face::Material material);

/// Texture coordinates of a triangle's corners: of one that goes over the seam (uv.x 1 is 0), the corners on
/// the far side stand at 0.
[[nodiscard]] std::array<Eigen::Vector2f, 3> uv_of(const face::Face& face,
                                                   const std::array<std::uint32_t, 3>& triangle);

/// Of each vertex of a face with uv the direction in which uv.x grows, at a right angle to its normal, and 1:
/// glTF's tangent.
[[nodiscard]] std::vector<Eigen::Vector4f> tangents_of(const face::Face& face,
                                                       std::span<const Vec3f> normals);

inline constexpr int kLargestTexture = 8192;  ///< Pixels a side.

/// Square pictures of the paint, RGB, rows from the top.
struct FaceTextures {
  int side_px = 0;
  std::vector<std::uint8_t> albedo;     ///< sRGB.
  std::vector<std::uint8_t> roughness;  ///< Green, linear; blue 0 (no metal).
  std::vector<std::uint8_t> normal;     ///< Of the pores, in the frame of tangents_of.
};

/// What the paint shows at each texel of the layout in face.uv; beyond its charts the nearest colours go on.
/// `thread_count` 0: one a core. Errors: bad_usage (the layout leaves the picture or lies on itself),
/// malformed (coordinates, colours or marks that do not fit the vertices), out_of_range (the side).
[[nodiscard]] Result<FaceTextures> bake_textures(const face::Face& face, const SurfacePaint& paint,
                                                 int side_px, int thread_count = 0);

/// The same as JPEG.
struct TextureFiles {
  std::vector<std::byte> albedo, roughness, normal;
};

/// Errors: bake_textures', encode_jpeg's.
[[nodiscard]] Result<TextureFiles> bake_texture_files(const face::Face& face, const SurfacePaint& paint,
                                                      int side_px, int thread_count = 0);

/// By what names such files are found beside a glTF asset that holds none.
inline constexpr std::string_view kAlbedoFile = "face_albedo.jpg", kRoughnessFile = "face_roughness.jpg",
                                  kNormalFile = "face_normal.jpg";

}  // namespace mien::render
