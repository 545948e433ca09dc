#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/core/wav.h"
#include "mien/face/motion.h"
#include "mien/take/take.h"

namespace mien::app {

/// What a command can show or export: a motion, and what was heard with it.
struct Performance {
  face::Motion motion;
  std::optional<Sound> sound;  ///< From the motion's start.
  std::string face;            ///< What it was performed on; empty when unknown.
};

/// A track of truth as a motion, from its first frame's time.
[[nodiscard]] face::Motion motion_of(std::span<const take::TruthFrame> truth, std::string name);

/// Reads a Live Link CSV, saying on stderr what was survived in it, or the truth in a take (.mien), whose
/// sound may be left out: that of hours takes a gigabyte. Errors: the readers', and not_found for a take
/// without truth.
[[nodiscard]] Result<Performance> load_performance(const std::filesystem::path& path, bool with_sound = true);

}  // namespace mien::app
