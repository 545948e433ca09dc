#pragma once

#include <vector>

#include "mien/live/page_server.h"

namespace mien::app {

/// The page as it was built with the program; empty when it was left out (MIEN_PAGE=OFF).
[[nodiscard]] std::vector<live::Asset> page_files();

}  // namespace mien::app
