#include "mien/take/new_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace mien::take {
namespace fs = std::filesystem;

NewFile::~NewFile() {
  if (!made_) return;
  ::unlink(name_.c_str());
  ::unlink((name_ + "-journal").c_str());
}

Result<void> NewFile::make() {
  const int file = ::mkstemp(name_.data());
  if (file < 0)
    return fail(ErrorCode::io, std::strerror(errno), path_.string(), "check the folder and its permissions");
  made_ = true;
  ::close(file);
  return {};
}

Result<void> NewFile::put_in_place(bool replace) {
  if (!replace && fs::exists(fs::symlink_status(path_)))
    return fail(ErrorCode::bad_usage, "a file of this name has appeared meanwhile", path_.string(),
                "choose another name, or replace it with --force");
  // What an older take left beside itself would be rolled back into the new one; should this fail, it is
  // the older one's again.
  const std::string journal = path_.string() + "-journal", aside = name_ + "-older-journal";
  const bool set_aside = ::rename(journal.c_str(), aside.c_str()) == 0;
  int done = -1;
  if (replace) {
    done = ::rename(name_.c_str(), path_.c_str());
  } else {
    done = ::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE);
    // Some file systems cannot; the check at the start stands for it there.
    if (done != 0 && (errno == EINVAL || errno == ENOSYS)) done = ::rename(name_.c_str(), path_.c_str());
  }
  if (done != 0) {
    const int problem = errno;
    if (set_aside) ::rename(aside.c_str(), journal.c_str());
    return fail(ErrorCode::io, std::strerror(problem), path_.string());
  }
  if (set_aside) ::unlink(aside.c_str());
  made_ = false;
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  const int handle = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle >= 0) {
    ::fsync(handle);
    ::close(handle);
  }
  return {};
}

}  // namespace mien::take
