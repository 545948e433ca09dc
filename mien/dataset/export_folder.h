#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::dataset {

/// The name of the file that describes an export; it is put in place last.
inline constexpr std::string_view kDatasheetName = "datasheet.md";

/// Where an export is written: a folder, in which files appear when all of them are whole. Until finish()
/// they are in a folder of their own within it, which is gone whatever happens, but for a kill.
class ExportFolder {
 public:
  /// Makes the folder where there is none. `force`: an export that is there already is replaced, by finish();
  /// what else is in the folder stays. Errors: bad_usage (a file; an export is there), not_found (the folder
  /// that it is to be in), io.
  [[nodiscard]] static Result<ExportFolder> create(const std::filesystem::path& folder, bool force);
  ExportFolder(ExportFolder&& other) noexcept;
  ExportFolder& operator=(ExportFolder&&) = delete;
  ~ExportFolder();

  /// Where a file of this name is to be written to; the name is one of an export's.
  [[nodiscard]] std::filesystem::path path_of(std::string_view name);
  /// Puts all files in place. Errors: io.
  [[nodiscard]] Result<void> finish();

 private:
  ExportFolder(std::filesystem::path folder, bool made) : folder_(std::move(folder)), made_(made) {}

  std::filesystem::path folder_;
  bool made_ = false;                 // It was not there before.
  std::filesystem::path unfinished_;  // Empty: nothing is to be cleaned up.
  std::vector<std::string> names_;
};

/// Whether a file's name is one that an export gives: "train.safetensors", "train-2.safetensors",
/// "datasheet.md".
[[nodiscard]] bool is_exports_name(std::string_view name);

}  // namespace mien::dataset
