#include "app/live/demo_session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>

#include "app/live/page_address.h"

namespace mien::app {

Result<LiveSession> open_demo_session(LiveRequest request) {
  auto opened = open_live(request);
  if (!opened && request.page != "off" && opened.error().code == ErrorCode::bad_usage) {
    request.page = "127.0.0.1:0";
    opened = open_live(request);
  }
  if (!opened) return opened;
  if (const std::string page = opened->engine->page(); !page.empty()) {
    fmt::print(stderr, "The page is at {} (open it in a browser to watch)\n",
               fmt::join(openable_addresses(page, own_addresses()), "\n            or "));
    std::fflush(stderr);
  }
  return opened;
}

}  // namespace mien::app
