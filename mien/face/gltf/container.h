#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "mien/core/error.h"

namespace mien::face::gltf {

/// The largest file that is read, in bytes: the asset's own and each that it names.
inline constexpr std::size_t kMaxBytes = std::size_t{1} << 30U;

/// What tinygltf may read from the disk: plain files in the glTF's own folder and beneath it.
struct Folder {
  std::filesystem::path path;  ///< Canonical. Empty: nothing at all.

  [[nodiscard]] bool holds(const std::string& file) const;
};

/// Reads the container, .glb or .gltf with its buffers, without its pictures. Indices and sizes in the model
/// are the file's claims: nothing has checked them. `name` is what errors call the file. Errors: truncated,
/// out_of_range (larger than kMaxBytes), unsupported (glTF 1, compressed meshes), malformed.
[[nodiscard]] Result<tinygltf::Model> read_container(std::span<const std::byte> bytes,
                                                     const std::string& name, Folder& folder);

}  // namespace mien::face::gltf
