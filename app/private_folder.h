#pragma once

#include <filesystem>
#include <utility>

#include "mien/core/error.h"

namespace mien::app {

/// A folder for this process alone, gone with it.
class PrivateFolder {
 public:
  /// Errors: io.
  [[nodiscard]] static Result<PrivateFolder> make();
  PrivateFolder(PrivateFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  PrivateFolder& operator=(PrivateFolder&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  ~PrivateFolder();
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit PrivateFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

/// Makes a folder for what shows a person's face, and those above it that are missing: nobody but their owner
/// may look into them (mode 700), whatever the umask. One that is there stays as it is. Errors: io.
[[nodiscard]] Result<void> make_private_folders(const std::filesystem::path& folder);

}  // namespace mien::app
