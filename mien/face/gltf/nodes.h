#pragma once

#include <tiny_gltf.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/gltf/arrays.h"

namespace mien::face::gltf {

/// A node of the scene, and where it stands in the world: the file's frame and unit.
struct Placed {
  int node = -1;  ///< In the model's nodes.
  Eigen::Matrix4d world = Eigen::Matrix4d::Identity();
};

/// Every node of the scene once, parents first. A node that is reached twice (which glTF forbids, and which
/// could go round for ever) counts the first time. Errors: malformed (a node that is not there, more than
/// 100000 of them, nested deeper than 512), out_of_range (a transform beyond 1e9).
[[nodiscard]] Result<std::vector<Placed>> place_nodes(const tinygltf::Model& model, const Arrays& arrays);

/// Each vertex's matrix into the world: its node's, one for all, or where the primitive is skinned the mean
/// of its joints' at rest, one a vertex. `worlds` stands beside the model's nodes. Errors: malformed,
/// truncated, out_of_range.
[[nodiscard]] Result<std::vector<Eigen::Matrix4d>> vertex_matrices(
    const tinygltf::Model& model, const tinygltf::Primitive& primitive, const tinygltf::Node& node,
    const Eigen::Matrix4d& world, const std::vector<Eigen::Matrix4d>& worlds, std::size_t vertices,
    const Arrays& arrays);

}  // namespace mien::face::gltf
