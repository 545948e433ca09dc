#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::face {

/// A run of triangles with one material, in file order.
struct ObjGroup {
  std::string material;  ///< As `usemtl` names it; empty before the first.
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
};

/// The geometry of a Wavefront OBJ. Texture coordinates and normals are left out: nothing here uses them.
struct ObjMesh {
  std::vector<Vec3f> position;                          ///< In the file's own unit.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Polygons are cut into fans.
  std::vector<ObjGroup> groups;                         ///< Cover all triangles in order.
};

/// What parse_obj reads. Blendshape meshes share one topology, so all but the first need positions only.
enum class ObjContent { positions, positions_and_faces };

/// Reads the text of an OBJ. `name` is what errors call it. Unknown statements are skipped.
/// Errors: malformed, out_of_range (a number that is not finite, an index without a vertex, a mesh beyond
/// 16 million vertices or triangles), truncated (no vertex at all).
/// Memory grows with what was read, never with what an index claims. Thread-safe.
[[nodiscard]] Result<ObjMesh> parse_obj(std::string_view text, std::string_view name,
                                        ObjContent content = ObjContent::positions_and_faces);

/// The face in one pose as the text of an OBJ in metres, one group a part. `vertices_m` beside
/// face.neutral_m.
[[nodiscard]] std::string format_obj(const Face& face, std::span<const Vec3f> vertices_m);

}  // namespace mien::face
