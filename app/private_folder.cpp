#include "app/private_folder.h"

#include <stdlib.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace mien::app {
namespace fs = std::filesystem;

Result<PrivateFolder> PrivateFolder::make() {
  std::error_code code;
  std::string name = (fs::temp_directory_path(code) / "mien-XXXXXX").string();
  if (code || ::mkdtemp(name.data()) == nullptr)
    return fail(ErrorCode::io, std::strerror(errno), "the temporary folder",
                "set TMPDIR to a folder that can be written");
  return PrivateFolder(name);
}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<void> make_private_folders(const fs::path& folder) {
  fs::path made;
  int problem = ENOENT;
  for (const fs::path& part : folder) {
    made /= part;
    if (!part.empty()) problem = ::mkdir(made.c_str(), 0700) == 0 ? 0 : errno;
  }
  // Those that were there could not be made either.
  std::error_code code;
  if (fs::is_directory(made, code)) return {};
  return fail(ErrorCode::io, std::strerror(problem), folder.string(),
              "choose a folder in a place where you may write");
}

}  // namespace mien::app
