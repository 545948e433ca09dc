#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/take/database.h"

namespace mien::take {

/// A folder of this program's own under the temporary one, gone with this.
class TemporaryFolder {
 public:
  [[nodiscard]] static Result<TemporaryFolder> make();
  TemporaryFolder() = default;
  TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  TemporaryFolder& operator=(TemporaryFolder&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  ~TemporaryFolder();
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A take's database, open for reading, in one read transaction that the caller ends.
struct OpenTake {
  TemporaryFolder
      folder;  ///< Holds the copy, where one had to be made. Declared first: it must outlive the database.
  Database database;
  std::int64_t version = 0;  ///< Of the layout: which tables it has (Table::since).
};

/// Opens a file that nobody vouches for: it is a SQLite file of our application id and a known version, not
/// in WAL mode, with exactly that version's tables and nothing else (no trigger, view or index could run),
/// its pages are sound; limits are lowered and the defensive settings on. A commit that was cut off is rolled
/// back, here or on a copy. Errors: as Take::open.
[[nodiscard]] Result<OpenTake> open_untrusted(const std::filesystem::path& path);

/// What SQLite's quick_check or integrity_check says of a file's pages, as a result: "ok", or what is wrong.
/// Errors: malformed.
[[nodiscard]] Result<void> judge_pages(std::string_view verdict, const std::string& where);

}  // namespace mien::take
