#pragma once

#include <string_view>

namespace mien::live {

/// Whether a session in this state of its prompts (session::Report::Prompts::state) asks for one, now or once
/// the performer goes on. Lines of a block wait before it, too: `block`.
[[nodiscard]] inline bool asks_for_pose(std::string_view prompts) {
  return prompts == "ready" || prompts == "running" || prompts == "paused";
}
[[nodiscard]] inline bool asks_in(std::string_view prompts) {
  return prompts == "block" || asks_for_pose(prompts);
}

}  // namespace mien::live
