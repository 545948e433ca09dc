#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace mien::test {

/// A folder that nobody else has, and that is gone after the test.
class Folder {
 public:
  enum class On {
    disk,
    memory,  ///< Where there is such a place: every commit of a take waits for its disk, and a busy one is
             ///< not ours to answer for.
  };

  explicit Folder(On on = On::disk) {
    const std::filesystem::path memory = "/dev/shm";
    const bool use_memory = on == On::memory && std::filesystem::is_directory(memory);
    std::string name =
        ((use_memory ? memory : std::filesystem::temp_directory_path()) / "mien-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "no temporary folder";
    path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code code;
    std::filesystem::permissions(path_, std::filesystem::perms::owner_all, code);
    std::filesystem::remove_all(path_, code);
  }

  [[nodiscard]] std::filesystem::path operator/(const std::filesystem::path& name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Every file in it, sorted.
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& file : std::filesystem::recursive_directory_iterator(path_))
      names.push_back(file.path().string());
    std::ranges::sort(names);
    return names;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace mien::test
