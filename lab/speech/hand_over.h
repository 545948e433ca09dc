#pragma once

#include <cstddef>
#include <span>

#include "mien/face/output_frame.h"
#include "mien/measure/metrics.h"
#include "mien/synthetic/speech/spoken_passage.h"

// Somebody speaks, and for a while nothing can be sensed of mouth and jaw.
namespace mien::lab {

/// Frames [lost, back) in which nothing can.
struct Unsensed {
  std::size_t lost = 0, back = 0;
};

struct HandOver {
  /// Root mean square of the third difference of mouth and jaw about the loss and about the return, from a
  /// quarter of a second before sensors go or come to a quarter after another answers, over that of the
  /// same moments without a change: while sensors answer as they show them, while sound does as it does all
  /// along; where nothing answers as sensors do. The larger of the two.
  double jerk_ratio = 0;
  /// From the loss until no weight of mouth or jaw claims to be sensed; infinite where that does not happen
  /// before the return.
  double notice_s = 0;
  double recover_s = 0;  ///< From the return until all are the sensors' again; infinite where never.
  double mouth_mm = 0;  ///< Mean error of the face's vertices during the loss, mouth and jaw alone moving it.
};

/// What is shown of such a performance; frames of all spans are 60 Hz and of the same moments. `steady`: the
/// same with all sensors all the time; `meanwhile`: by whoever answers during the loss, alone all the time.
struct ShownOver {
  std::span<const face::OutputFrame> shown, steady, meanwhile;
  std::span<const face::BlendshapeWeights> truth;
};
/// `loss`: from a quarter of a second after the first frame to as long before the last.
[[nodiscard]] HandOver judge_hand_over(const Unsensed& loss, const ShownOver& over,
                                       const measure::Meter& meter);

/// Whether a weight of that provenance claims to come from sensors.
[[nodiscard]] bool claims_to_be_sensed(face::Provenance provenance);

/// When in the passage something that lasts `for_s` is best lost: in the middle of what is said, not in the
/// pause between two lines. From 1 s after the passage's begin to 1 s before its end.
[[nodiscard]] double mid_sentence(const synthetic::SpokenPassage& passage, double for_s);

}  // namespace mien::lab
