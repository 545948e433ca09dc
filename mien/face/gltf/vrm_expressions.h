#pragma once

#include <tiny_gltf.h>

#include "mien/face/gltf/binding.h"

namespace mien::face::gltf {

/// Binds shapes that have none yet by the VRM expressions named after them: blend shape groups of VRM 0,
/// custom expressions of VRM 1. What is not of VRM's form is passed over. Source: VRM Consortium,
/// specifications 0.0 and VRMC_vrm-1.0.
void bind_vrm_expressions(const tinygltf::Model& model, Binding& binding);

}  // namespace mien::face::gltf
