#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/model/features.h"

namespace mien::phone {

/// Where a phone's time probably is on the sensors', from the arrivals of both; without it, anywhere. Times
/// are s: the sensors' from the first frame of features on, the phone's from its track's first.
struct AlignmentPrior {
  double offset_s = 0;         ///< The sensors' time at which the phone's is 0.
  double offset_window_s = 1;  ///< The offset is within plus and minus this of it.
  double drift_ppm = 0;
  double drift_sigma_ppm = 30;  ///< Of two crystals of phones and boards.
};

/// How one stretch of a take agrees with the line through all.
struct AlignmentBlock {
  double begin_s = 0, end_s = 0;  ///< Sensors' time.
  double residual_s = 0;          ///< Its own offset less the line's.
  double sigma_s = 0;             ///< Standard deviation of that.
  double agreement = 0;           ///< As TimeAlignment has it, of this stretch.
};

/// A phone's time on the sensors', as the face tells it: what a phone shows at p was felt at
/// middle_s + (p - (middle_s - offset_s)) * (1 + 1e-6 * drift_ppm).
struct TimeAlignment {
  double middle_s = 0;  ///< Of what both saw, sensors' time.
  double offset_s =
      0;  ///< There: sensors' time less the phone's. The phone's own lag is in it, kSkinLagS is not.
  double offset_sigma_s = 0;
  double drift_ppm = 0;  ///< By how much the phone's clock is slow.
  double drift_sigma_ppm = 0;
  /// Share of the variance of jaw and smile that the skin's rotations foretell, by a linear map that was
  /// fitted to the other half of the take; below 1, and below 0 where they have nothing to do with each
  /// other.
  double agreement = 0;
  double overlap_s = 0;  ///< How long both were there.
  std::vector<AlignmentBlock> blocks;

  [[nodiscard]] double to_phone_s(double sensors_s) const {
    return middle_s - offset_s + (sensors_s - middle_s) / (1 + 1e-6 * drift_ppm);
  }
};

/// A sensor on the skin follows it by so much later, which the phone's time is not to be blamed for: an
/// adhesive's lag as the eleven sensors of virtual wearers have it together (rigs/default.toml: 5 to 20 ms
/// each), and its standard deviation between wearers, s. The mean of eleven such has 1.3 ms; more, since with
/// that the stated sigma held too seldom (docs/experiments/phone_truth.md).
inline constexpr double kSkinLagS = 0.0103, kSkinLagSigmaS = 1.8e-3;
/// Least share of jaw's and smile's variance that a phone of the same performer must have explained.
inline constexpr double kLeastAgreement = 0.3;
/// Least time that phone and sensors must have seen together, s.
inline constexpr double kLeastOverlapS = 10;

/// Finds offset and drift at which what the phone tells is best foretold from how skin turns, linearly: the
/// profile likelihood of a regression, by cross-correlation first and then by Newton's method; sigmas from
/// how far stretches of the take scatter about the line. `skin`: one frame a tick of the grid. `told`:
/// weights of the phone's own time. Method: docs/method/phone_truth.md. Cost: under a second of one core for
/// two minutes.
///
/// Errors: not_found (too little seen together, nothing moves), mismatch (they disagree at every offset, or
/// agree as well at several: another performer's, another take's).
[[nodiscard]] Result<TimeAlignment> align(std::span<const model::FeatureFrame> skin, const face::Motion& told,
                                          const std::optional<AlignmentPrior>& prior);

}  // namespace mien::phone
