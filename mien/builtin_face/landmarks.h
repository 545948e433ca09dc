#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mien/builtin_face/mesh.h"

namespace mien::builtin_face {

/// Multi-PIE's 68 on the sculpted head: each the vertex nearest to its place, the right ones mirrored.
[[nodiscard]] std::array<std::uint32_t, 68> find_landmarks(const Sculpt& s);

/// The regions of Face::regions, by place and tissue.
[[nodiscard]] std::vector<face::Region> find_regions(const Sculpt& s);

}  // namespace mien::builtin_face
