#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "mien/core/error.h"

namespace mien::take {

/// Makes a new file at `path` in one piece: it is filled under another name and then renamed, so at any
/// moment there is no file, the old one, or the new one. Nobody but its owner may read or write it (mode
/// 600), whatever the umask: takes hold a person's face. SQLite gives the journal beside it the same mode.
class NewFile {
 public:
  explicit NewFile(std::filesystem::path path) : path_(std::move(path)), name_(path_.string() + ".XXXXXX") {}
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();  ///< What is not in place is removed.

  /// Makes the empty file under its other name. Errors: io.
  [[nodiscard]] Result<void> make();
  /// Errors: bad_usage (a file of its name has appeared, and not `replace`), io.
  [[nodiscard]] Result<void> put_in_place(bool replace);

  /// The name under which it is filled.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::filesystem::path path_;
  std::string name_;
  bool made_ = false;
};

}  // namespace mien::take
