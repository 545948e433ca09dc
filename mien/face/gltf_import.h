#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/face/target_names.h"

namespace mien::face {

/// A head read from glTF, and what was made of it.
struct GltfHead {
  Face face;
  double metres_per_unit = 1;        ///< 1 where the file keeps to glTF's metres.
  std::vector<std::string> missing;  ///< Shapes that the file does not have; they move nothing.
  std::vector<std::string> warnings;
};

/// Reads a .glb, .gltf or .vrm head with ARKit-named morph targets: names from `targetNames` in the extras of
/// mesh or primitive; shapes that no target is named after from VRM 0 blend shape groups or VRM 1 custom
/// expressions. All meshes of the scene are merged, with their nodes' transforms and skins at rest. A head
/// that looks along -Z (VRM 0) is turned round; one that is not in metres is brought to them: of metre, inch,
/// centimetre and millimetre the one that makes the moving part of the face best the size of a person's, and
/// failing all, a face of 0.2 m. browInnerUp and cheekPuff in one piece are split into sides by a smooth ramp
/// of 4 cm, whose halves add up to it. Region "skin" is the meshes with shapes, teeth, tongue and eyes left
/// out. There are no landmarks. Eyeballs are meshes named "eye" that no shape moves. Errors: malformed,
/// truncated, out_of_range (no index or size in the file is believed before its bytes are there; at most 4
/// million vertices), unsupported (compressed meshes), not_found (no morph target has an ARKit name). Files
/// that the glTF names are read only from its own folder and those beneath it.
[[nodiscard]] Result<GltfHead> import_gltf(const std::filesystem::path& path);
/// The same from memory; files that it names are not read, which is an error if a mesh needs them.
[[nodiscard]] Result<GltfHead> parse_gltf(std::span<const std::byte> bytes, std::string_view name);

}  // namespace mien::face
