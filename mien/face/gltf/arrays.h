#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"

namespace mien::face::gltf {

/// The most triangles that a head may have.
inline constexpr std::size_t kMaxTriangles = 8'000'000;

/// The item that a file's index names; null when it names none.
template <class T>
const T* at(const std::vector<T>& items, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < items.size()
             ? &items[static_cast<std::size_t>(index)]
             : nullptr;
}

/// Reads a model's accessors; every size is held against the bytes that are there. Model and name (what
/// errors call the file) must outlive it.
class Arrays {
 public:
  Arrays(const tinygltf::Model& model, const std::string& name) : model_(model), name_(name) {}

  /// Rows of `width` numbers. `expected` is the number of rows where it is known; without it the rows must
  /// have bytes of their own. Normalised integers become fractions. Errors: malformed, truncated,
  /// out_of_range (a number that is not finite or beyond 1e9).
  [[nodiscard]] Result<std::vector<double>> read(int index, std::size_t width,
                                                 std::optional<std::size_t> expected) const;

  /// The error malformed, at this file.
  [[nodiscard]] std::unexpected<Error> bad(std::string what) const;

 private:
  [[nodiscard]] Result<std::vector<double>> strided(int view_index, std::size_t offset, int type,
                                                    std::size_t width, std::size_t count,
                                                    bool normalized) const;

  const tinygltf::Model& model_;
  const std::string& name_;
};

}  // namespace mien::face::gltf
