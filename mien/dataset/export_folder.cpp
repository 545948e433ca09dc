#include "mien/dataset/export_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <system_error>
#include <utility>

#include "mien/dataset/splits.h"

namespace mien::dataset {
namespace {

std::unexpected<Error> export_failed(const std::error_code& code, const std::filesystem::path& path) {
  return fail(ErrorCode::io, code.message(), path.string(), "choose a folder that can be written to");
}

/// Names of an export's files in a folder.
Result<std::vector<std::string>> exports_files(const std::filesystem::path& folder) {
  std::error_code code;
  std::vector<std::string> names;
  std::filesystem::directory_iterator at(folder, code);
  while (!code && at != std::filesystem::directory_iterator()) {
    std::string name = at->path().filename().string();
    if (is_exports_name(name)) names.push_back(std::move(name));
    at.increment(code);
  }
  if (code) return export_failed(code, folder);
  std::ranges::sort(names);
  return names;
}

}  // namespace

bool is_exports_name(std::string_view name) {
  if (name == kDatasheetName) return true;
  constexpr std::string_view kEnding = ".safetensors";
  if (!name.ends_with(kEnding)) return false;
  name.remove_suffix(kEnding.size());
  return std::ranges::any_of(kSplitNames, [name](std::string_view split) {
    if (!name.starts_with(split)) return false;
    std::string_view number = name.substr(split.size());
    if (number.empty()) return true;
    if (number.front() != '-') return false;
    number.remove_prefix(1);
    return !number.empty() &&
           std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c) != 0; });
  });
}

Result<ExportFolder> ExportFolder::create(const std::filesystem::path& folder, bool force) {
  namespace fs = std::filesystem;
  std::error_code code;
  const fs::file_status status = fs::status(folder, code);
  if (fs::exists(status) && !fs::is_directory(status))
    return fail(ErrorCode::bad_usage, "this is a file, not a folder", folder.string(), "name a folder");
  const bool there = fs::is_directory(status);
  if (there) {
    MIEN_TRY_ASSIGN(const std::vector<std::string> names, exports_files(folder));
    if (!force && !names.empty())
      return fail(ErrorCode::bad_usage, fmt::format("an export is there already ({})", names.front()),
                  folder.string(), "give another folder, or --force");
  } else if (!fs::create_directory(folder, code)) {
    if (code == std::errc::no_such_file_or_directory)
      return fail(ErrorCode::not_found, "the folder that it is to be in is not there", folder.string(),
                  "make it first");
    return export_failed(code, folder);
  }
  ExportFolder made(folder, !there);
  static std::atomic<unsigned> counter = 0;
  fs::path unfinished;
  do {
    unfinished = folder / fmt::format(".{}-{}.part", ::getpid(), counter++);
  } while (!fs::create_directory(unfinished, code) && !code);
  if (code) {
    if (made.made_) {
      std::error_code gone;
      fs::remove(folder, gone);
    }
    return export_failed(code, folder);
  }
  made.unfinished_ = std::move(unfinished);
  return made;
}

ExportFolder::ExportFolder(ExportFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      made_(other.made_),
      unfinished_(std::exchange(other.unfinished_, {})),
      names_(std::move(other.names_)) {}

ExportFolder::~ExportFolder() {
  if (unfinished_.empty()) return;
  std::error_code code;
  std::filesystem::remove_all(unfinished_, code);
  if (made_) std::filesystem::remove(folder_, code);  // Only where it is empty.
}

std::filesystem::path ExportFolder::path_of(std::string_view name) {
  if (std::ranges::find(names_, name) == names_.end()) names_.emplace_back(name);
  return unfinished_ / name;
}

Result<void> ExportFolder::finish() {
  namespace fs = std::filesystem;
  std::error_code code;
  // Whoever finds a datasheet finds what it describes.
  MIEN_TRY_ASSIGN(const std::vector<std::string> old, exports_files(folder_));
  fs::remove(folder_ / kDatasheetName, code);
  if (code) return export_failed(code, folder_);
  for (const std::string& name : old)
    if (std::ranges::find(names_, name) == names_.end()) {
      fs::remove(folder_ / name, code);
      if (code) return export_failed(code, folder_ / name);
    }
  std::ranges::partition(names_, [](const std::string& name) { return name != kDatasheetName; });
  for (const std::string& name : names_) {
    fs::rename(unfinished_ / name, folder_ / name, code);
    if (code) return export_failed(code, folder_ / name);
    made_ = false;
  }
  fs::remove_all(unfinished_, code);
  unfinished_.clear();
  return {};
}

}  // namespace mien::dataset
