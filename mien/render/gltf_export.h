#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/face/skin_marks.h"

namespace mien::render {

/// The container of a glTF 2.0 asset.
enum class GltfKind {
  binary,  ///< .glb
  text,    ///< .gltf with its buffer inside as base64.
};

/// By whose names a receiver knows the face's morph targets.
enum class GltfNames : std::uint8_t {
  ict,      ///< face::TargetNames::ict: ours.
  arkit,    ///< face::TargetNames::arkit.
  unified,  ///< face::TargetNames::unified.
  vrm,      ///< ARKit's, and an avatar by VRM 1.0 (VRM Consortium): bones, expressions, whereby it looks.
};

/// Pictures of the paint of skin, lips and eyeballs, for a face whose uv lays them out
/// (builtin_face::lay_out_textures).
struct GltfTextures {
  /// Side of the albedo, roughness and pores in the asset, JPEG; 0: none, colours at the vertices. Larger
  /// shows finer pores and takes more room: 1024 about 0.2 MB, 2048 0.6 MB.
  int side_px = 0;
  /// Without pictures inside: vertices have their texture coordinates, and materials say in `extras` under
  /// which names the pictures lie beside the asset, for a reader that shows the face before they are there.
  /// Not read where side_px is above 0.
  bool beside = false;
  face::SkinMarks marks;
};

/// A face as glTF 2.0: a head node that turns, a mesh with one sparse morph target a name (in
/// mesh.extras.targetNames), both eyeballs as nodes of their own where no shape moves them, colours at
/// the vertices or in pictures. With a motion, one animation at 60 frames a second: weights as performed,
/// head rotation and position, eyes. Metres, +Y up, +Z forward. The same input gives the same bytes. Errors:
/// out_of_range (a number that is not finite, or more than 4 GB), malformed (a triangle or shape that names a
/// vertex that is not there), bad_usage (nothing to write; textures of a face that is not laid out; as an
/// avatar, more than a head: kLargestHead_m). Source: Khronos, glTF 2.0 specification (ISO/IEC 12113:2022).
[[nodiscard]] Result<std::vector<std::byte>> encode_gltf(const face::Face& face, const face::Motion* motion,
                                                         GltfKind kind, GltfNames names = GltfNames::ict,
                                                         const GltfTextures& textures = {});

/// The same into a file, whole or not at all; the name's ending (.glb, .gltf, of an avatar .vrm too) chooses
/// the kind. Errors: those of encode_gltf and write_file, and bad_usage for another ending.
[[nodiscard]] Result<void> write_gltf(const std::filesystem::path& path, const face::Face& face,
                                      const face::Motion* motion, GltfNames names = GltfNames::ict,
                                      const GltfTextures& textures = {});

}  // namespace mien::render
