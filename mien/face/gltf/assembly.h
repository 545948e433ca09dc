#pragma once

#include <tiny_gltf.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/face/gltf/arrays.h"
#include "mien/face/gltf/binding.h"
#include "mien/face/gltf/nodes.h"
#include "mien/face/gltf_import.h"

namespace mien::face::gltf {

/// The head in the file's unit and direction, before it is made a Face.
struct Assembly {
  std::vector<Vec3> position;
  std::vector<Eigen::Vector2f> uv;  ///< Beside position; zero where the file has none.
  std::vector<Vec3f> colour;        ///< Beside position, while has_colour.
  bool has_uv = false;
  bool has_colour = true;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Part> parts;
  /// Each shape's displacements, vertices ascending; tongueOut at kShapeCount.
  std::array<std::vector<std::pair<std::uint32_t, Vec3>>, kShapeCount + 1> delta;
  std::size_t delta_count = 0;
  std::vector<bool> skin;  ///< Beside position.
  /// An eyeball's run of vertices.
  struct Eye {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::optional<Vec3> pivot;
  };
  std::vector<Eye> eyes;
};

/// Adds the mesh of a node that has one. `worlds` stands beside the model's nodes. Errors: malformed,
/// truncated, out_of_range (more than 4 million vertices, one that lies or moves beyond 1e9).
[[nodiscard]] Result<void> add_mesh(const tinygltf::Model& model, const Placed& placed,
                                    const std::vector<Eigen::Matrix4d>& worlds, const Binding& binding,
                                    Assembly& out, const Arrays& arrays);

/// Makes the assembly a Face: turned to frame H, in metres, shapes in one piece split into sides, eyeballs
/// and skin found. `name` is the file. Errors: malformed (its shapes move nothing).
[[nodiscard]] Result<GltfHead> finish(Assembly head, const Binding& binding, const std::string& name);

}  // namespace mien::face::gltf
