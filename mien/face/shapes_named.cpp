#include "mien/face/shapes_named.h"

#include <string>

#include "mien/face/profile.h"

namespace mien::face {

std::vector<std::size_t> shapes_named(std::string_view name) {
  if (const std::size_t one = shape_index(name); one < kShapeCount) return {one};
  const std::size_t left = shape_index(std::string(name) + "_L");
  const std::size_t right = shape_index(std::string(name) + "_R");
  if (left < kShapeCount && right < kShapeCount) return {left, right};
  return {};
}

}  // namespace mien::face
