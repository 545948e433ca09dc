#pragma once

#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien::eyewear {

/// One bench reading: the light reflected by a card of skin's reflectance at a known distance.
struct BenchReading {
  double distance_m = 0;
  double light = 0;  ///< LED on less LED off, share of full scale, > 0.
};

/// Linearisation of a photo-reflective sensor, light to distance: a polynomial in the light's logarithm,
/// since light falls as a power of the distance (a polynomial in the light itself oscillates where it is
/// dim). The response peaks at some millimetres and falls again nearer by, so the polynomial is valid beyond
/// the peak only; light is clamped to the bench's range, peak to dimmest. On skin of another reflectance than
/// the card's the distance has a nearly constant offset, which a linear model behind it absorbs. Method:
/// docs/method/eyewear.md; the degree is not in the paper (Asano et al. 2017).
class Linearisation {
 public:
  /// Least squares over the readings beyond the brightest. `degree` 1 to 8. Errors: bad_usage (degree; fewer
  /// readings beyond the peak than the polynomial has coefficients plus one), out_of_range (a reading that is
  /// not finite, a light or distance that is not above 0).
  [[nodiscard]] static Result<Linearisation> fit(std::span<const BenchReading> readings, int degree = 4);

  /// Distance, m; any finite light (clamped). No allocation.
  [[nodiscard]] double distance_m(double light) const;
  /// The range of valid light.
  [[nodiscard]] double dimmest() const { return dimmest_; }
  [[nodiscard]] double brightest() const { return brightest_; }

 private:
  double dimmest_ = 0;
  double brightest_ = 1;
  double centre_ = 0;  ///< Centre and scale of the logarithm, for conditioning.
  double scale_ = 1;
  std::vector<double> coefficients_;  ///< Ascending powers.
};

}  // namespace mien::eyewear
