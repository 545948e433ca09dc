#pragma once

#include <tiny_gltf.h>

#include <array>
#include <cstddef>
#include <vector>

#include "mien/face/profile.h"

namespace mien::face::gltf {

/// The most morph targets that a file may bind to shapes.
inline constexpr std::size_t kMaxBinds = 4096;

/// A target of a mesh, and how much of it makes the shape.
struct Bind {
  int mesh = -1;
  std::size_t target = 0;
  double weight = 1;
};

/// Which morph targets make which shape: arrays beside kShapeNames, tongueOut at kShapeCount.
struct Binding {
  std::array<std::vector<Bind>, kShapeCount + 1> binds;
  std::array<bool, kShapeCount + 1> split{};  ///< Half of a shape that the file has in one piece.
  std::size_t count = 0;                      ///< Goes on beyond kMaxBinds, binds do not.

  void add(std::size_t k, Bind bind);
  /// Shapes that have a bind.
  [[nodiscard]] std::array<bool, kShapeCount + 1> taken() const;
};

/// Binds by `targetNames` in the extras of mesh or primitive, then what is left by VRM expressions. Meshes
/// and targets that it names may not be there.
[[nodiscard]] Binding bind_shapes(const tinygltf::Model& model);

/// Binds shapes that have none yet by the VRM expressions named after them: blend shape groups of VRM 0,
/// custom expressions of VRM 1. What is not of VRM's form is passed over. Source: VRM Consortium,
/// specifications 0.0 and VRMC_vrm-1.0.
void bind_vrm_expressions(const tinygltf::Model& model, Binding& binding);

}  // namespace mien::face::gltf
