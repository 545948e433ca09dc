#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/face/obj.h"

// What parses is sound: every index names a vertex, every number is finite, the groups cover the triangles.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::face;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto mesh = parse_obj(text, "fuzz");
  const auto positions = parse_obj(text, "fuzz", ObjContent::positions);
  if (!mesh) return 0;
  if (!positions || positions->position != mesh->position) std::abort();
  for (const mien::Vec3f& v : mesh->position)
    if (!v.allFinite()) std::abort();
  for (const auto& triangle : mesh->triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= mesh->position.size()) std::abort();
  std::size_t covered = 0;
  for (const ObjGroup& group : mesh->groups) {
    if (group.first_triangle != covered) std::abort();
    covered += group.triangle_count;
  }
  if (covered != mesh->triangles.size()) std::abort();
  return 0;
}
