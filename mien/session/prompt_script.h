#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/session/prompt.h"

namespace mien::session {

/// Poses and lines to ask for, one after the other: a data file, prompts/*.toml (docs/guide/recording.md).
struct PromptScript {
  std::string name;
  std::string language;         ///< Of texts that name none, as Prompt::language.
  std::vector<Prompt> prompts;  ///< One or more, kMaxPrompts at most.

  [[nodiscard]] double seconds() const;  ///< Of all together.
};

/// A shape's name stands for itself; one whose sides have names of their own ("mouthSmile") for both. Errors:
/// malformed TOML (with line), an unknown key, no pose, two lines of one name; out_of_range (a value that
/// check_prompt refuses, too many). `where` names the source in messages.
[[nodiscard]] Result<PromptScript> parse_prompts(std::string_view toml, const std::string& where);
/// Errors: the file's, parse_prompts'.
[[nodiscard]] Result<PromptScript> read_prompts(const std::filesystem::path& path);

}  // namespace mien::session
