#include "app/private_folder.h"

#include <stdlib.h>

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

}  // namespace mien::app
