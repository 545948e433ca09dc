#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/wav.h"
#include "mien/face/motion.h"
#include "mien/session/prompt_script.h"

namespace mien::app {

/// A virtual performer who goes through a recording script, and what they ask of the session meanwhile.
struct ScriptedPerformance {
  face::Motion motion;
  std::optional<Sound> sound;  ///< From the motion's start; none where nothing is read.
  /// A word of the page's command `prompts`, and the time of the motion at which it is said, s.
  struct Step {
    double at_s = 0;
    std::string word;  ///< "begin" or "next".
  };
  std::vector<Step> steps;  ///< By time.
};

/// The time of the motion from which a recording may begin: until then the performer rests.
inline constexpr double kScriptBeginS = 1.5;

/// Reads each text aloud by espeak-ng with the face of its emotion, and makes each pose as people do: late,
/// and more or less of it. Everything that is drawn comes from `seed`: the style is that of
/// virt::set_stage's performer with this seed. Errors: what mien-media says; cancelled.
[[nodiscard]] Result<ScriptedPerformance> perform_script(const session::PromptScript& script,
                                                         std::uint64_t seed, const Progress& progress);

}  // namespace mien::app
