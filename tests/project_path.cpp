#include "tests/project_path.h"

namespace mien {

std::string project_path(const std::string& path) {
  return MIEN_SOURCE_DIR "/" + path;
}

}  // namespace mien
