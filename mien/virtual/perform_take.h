#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/virtual/performer_prologue.h"
#include "mien/virtual/script.h"

namespace mien::virt {

/// What `mien perform --take` is asked for.
struct PerformRequest {
  std::string motion;  ///< A Live Link CSV; empty: a virtual performer plays `block`.
  Block block = Block::mixed;
  double seconds = 60;             ///< Of the script; a motion has its own length.
  std::string face = "builtin";    ///< As face::load_face takes it.
  std::filesystem::path rig;       ///< Rig file.
  std::string devices = "device";  ///< "device": the rig's own faults; "lab"; or a TOML file of faults.
  std::uint64_t seed = 1;
  PrologueKind prologue = PrologueKind::brief;
  std::filesystem::path take;
  bool replace = false;
  bool real_time = false;  ///< Write the take at the pace of its packets' arrivals.
  std::string software;    ///< Goes into the take's header.
};

/// What was written.
struct PerformSummary {
  double duration_s = 0;
  std::size_t frames = 0;
  std::size_t packets = 0;
  std::size_t samples = 0;
};

/// Performs into a take. A cancelled or failed run at full speed leaves no file; at real pace the take stays
/// as far as it came. Errors: those of the readers; bad_usage (the take exists); io; cancelled.
[[nodiscard]] Result<PerformSummary> perform_take(const PerformRequest& request, const Progress& progress);

}  // namespace mien::virt
