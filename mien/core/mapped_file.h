#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "mien/core/error.h"

namespace mien {

/// A file's bytes as memory: they are read from the disk as they are looked at, and the system may forget
/// them again. For files that this program wrote and that nobody shortens meanwhile: who looks at bytes that
/// are gone is ended by the system.
class MappedFile {
 public:
  /// Errors: not_found, io (it cannot be opened, or is empty).
  [[nodiscard]] static Result<MappedFile> open(const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~MappedFile();

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> bytes_;
};

}  // namespace mien
