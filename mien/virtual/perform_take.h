#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/wav.h"
#include "mien/face/motion.h"
#include "mien/virtual/performer_prologue.h"
#include "mien/virtual/script.h"

namespace mien::virt {

/// The longest performance, s: two hours take five gigabytes while they are simulated.
inline constexpr double kLongestPerformanceS = 7200;

/// What `mien perform --take` is asked for.
struct PerformRequest {
  Script script;                       ///< What a virtual performer plays, ...
  std::optional<face::Motion> motion;  ///< ... unless this is performed instead.
  std::string script_name;             ///< Goes into the take's header: the block, or the motion's file.
  std::optional<Sound> sound;          ///< What is heard with it, from its start; goes into the take.
  std::string face = "builtin";        ///< As face::load_face takes it.
  std::filesystem::path rig;           ///< Rig file.
  std::string devices = "device";      ///< "device": the rig's own faults; "lab"; or a TOML file of faults.
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

/// Whether the take may be written, to be asked before long work. Errors: bad_usage (it exists, and is not to
/// be replaced).
[[nodiscard]] Result<void> check_take_is_new(const PerformRequest& request);

/// Performs into a take. A cancelled or failed run at full speed leaves no file; at real pace the take stays
/// as far as it came. Errors: those of the readers; bad_usage (the take exists); out_of_range (too long); io;
/// cancelled.
[[nodiscard]] Result<PerformSummary> perform_take(const PerformRequest& request, const Progress& progress);

}  // namespace mien::virt
