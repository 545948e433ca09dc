#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/motion.h"

namespace mien::study {

struct RestingRequest {
  int wearers = 30;      ///< Drawn for each script; a third of each kind of face.
  double seconds = 120;  ///< Of each performance, above 60.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// What a tracker reads of a face at rest.
enum class RestingKind : std::uint8_t {
  usual,       ///< 0 everywhere.
  narrow,      ///< eyeBlink 0.3 (sigma 0.03).
  raised,      ///< The brows' raisers 0.25 (sigma 0.03).
  of_several,  ///< Lids 0.1 to 0.4, both raisers or the lowering brows 0.1 to 0.3, smile or frown to 0.25.
};
inline constexpr std::array<std::string_view, 4> kRestingKindNames = {"usual", "narrow eyes", "raised brows",
                                                                      "several"};

/// Mean over some frames and shapes of the error without the step and with it.
struct BeforeAfter {
  double before = 0;
  double after = 0;
};

/// One kind of face in one kind of script: all from 30 s on, but for the curve. Of the shapes whose rest is
/// unusual; of a usual face, of all to which the step applies.
struct RestingResult {
  RestingKind kind = RestingKind::usual;
  std::string_view script;
  BeforeAfter resting;  ///< |w| where the truth is at most 0.02.
  BeforeAfter active;   ///< |w - truth| where the truth is 0.3 or more.
  BeforeAfter all;      ///< |w - truth| over all frames.
  std::optional<BeforeAfter> blink_f1;
  BeforeAfter wide;              ///< Mean eyeWide where its truth is 0.3 or more, over the truth's own mean.
  std::array<double, 12> curve;  ///< `resting` with the step, in each 5 s of the first minute.
};

/// What comes out of a rest of 20 s, a smile of 40 s and another rest, every 5 s.
struct LongSmile {
  double smile = 0;
  std::vector<double> shown;
};

struct RestingStudy {
  std::vector<RestingResult> results;  ///< By script, then kind.
  std::vector<LongSmile> smiles;
};

/// What the streaming calibration (shaping::Resting) does for virtual wearers. A tracker reads rest + (full -
/// rest) gain w, with gain 1 (sigma 0.1) a shape and noise of 0.01; lids are full at 0.8 to 1 of faces that
/// are not usual. The same request gives the same numbers, whatever the number of threads. Errors: bad_usage
/// (too few, too short); cancelled.
[[nodiscard]] Result<RestingStudy> study_resting(const RestingRequest& request, const Progress& progress);

/// The lower third of each shape of a recorded performance after its first 30 s, as it was recorded and with
/// the step; in the profile's order.
[[nodiscard]] std::vector<BeforeAfter> rests_of(const face::Motion& motion);

}  // namespace mien::study
