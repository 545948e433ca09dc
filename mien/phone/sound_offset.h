#pragma once

#include "mien/core/error.h"
#include "mien/core/wav.h"

namespace mien::phone {

/// The time of a sound on that of another, which heard the same room: what the other has at p was heard by
/// the first at to_first_s(p).
struct SoundOffset {
  double middle_s = 0;        ///< Of what both heard, the first's time.
  double offset_s = 0;        ///< There: the first's time less the other's.
  double offset_sigma_s = 0;  ///< By how far the blocks scatter about the line.
  double drift_ppm = 0;       ///< By how much the other's clock is slow.
  double drift_sigma_ppm = 0;
  /// The envelopes' correlation there, against the best one that is another offset; kLeastSoundScore or more.
  double score = 0;
  double agreeing = 0;   ///< Share of the blocks whose own offset lies on the line.
  double overlap_s = 0;  ///< How long both were there.

  [[nodiscard]] double to_first_s(double other_s) const {
    return middle_s + (other_s - (middle_s - offset_s)) * (1 + 1e-6 * drift_ppm);
  }
};

/// Least time that both must have heard, s.
inline constexpr double kLeastSoundS = 5;
/// Least ratio of the best to the second best offset. Of pairs of drawn sounds that are unrelated 40 % of 6 s
/// came beyond it, 8 % of 15 s, and each was refused by its blocks; raising refuses more of what is noisy.
inline constexpr double kLeastSoundScore = 1.3;

/// Finds by how much two recordings of one room are apart: the correlation of their envelopes in four bands
/// at every offset, then generalized cross-correlation with phase transform (Knapp and Carter 1976,
/// doi:10.1109/TASSP.1976.1162830) in up to 60 blocks within 0.4 s of it, and the line on which most of them
/// lie. Loudness, tone, polarity and noise may differ; rates too. A pure function. Cost: some seconds of one
/// core and 0.5 GB for two hours.
///
/// Errors: not_found (one is shorter than kLeastSoundS, or silent), mismatch (no offset stands out, or its
/// blocks do not agree: another room, or another time).
[[nodiscard]] Result<SoundOffset> sound_offset(const Sound& first, const Sound& other);

}  // namespace mien::phone
