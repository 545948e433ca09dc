#include <cstdint>
#include <cstdlib>

#include "mien/face/gltf_import.h"

// What parses is a sound face: all shapes in order, every index in its list, every number finite.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::face;
  const auto head = parse_gltf(std::as_bytes(std::span(data, size)), "fuzz");
  if (!head) return 0;
  const Face& face = head->face;
  const std::size_t vertices = face.neutral_m.size();
  for (const mien::Vec3f& v : face.neutral_m)
    if (!v.allFinite()) std::abort();
  for (const auto& triangle : face.triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= vertices) std::abort();
  if (face.shapes.size() < kShapeCount) std::abort();
  for (const Shape& s : face.shapes) {
    if (s.vertex.size() != s.delta_m.size()) std::abort();
    for (std::size_t i = 0; i < s.vertex.size(); ++i)
      if (s.vertex[i] >= vertices || (i > 0 && s.vertex[i] <= s.vertex[i - 1]) || !s.delta_m[i].allFinite())
        std::abort();
  }
  if (!face.uv.empty() && face.uv.size() != vertices) std::abort();
  if (!face.colour.empty() && face.colour.size() != vertices) std::abort();
  for (const Eyeball& eye : face.eyes)
    if (eye.first_vertex + eye.vertex_count > vertices || !eye.centre_m.allFinite()) std::abort();
  return 0;
}
