#pragma once

#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien::eyewear {

/// One reading on the bench: how much light came back from a card of skin's reflectance at a known distance.
struct BenchReading {
  double distance_m = 0;
  double light = 0;  ///< LED on less LED off, share of full scale.
};

/// From a photo-reflective sensor's light back to the distance of what it looks at: a polynomial of the
/// light's logarithm, since the light falls as a power of the distance and a polynomial of the light itself
/// swings where the light is dim. Such parts have a peak of light some millimetres off, nearer than which it
/// falls again: the polynomial holds beyond the peak only, and light above the peak's, or below the dimmest
/// of the bench, is held to these. On skin that is darker or brighter than the card the distance is off by an
/// amount that a linear model after it takes up.
class Linearisation {
 public:
  /// Least squares over the readings beyond the brightest. `degree` 1 to 8. Errors: bad_usage (degree; fewer
  /// readings beyond the peak than the polynomial has coefficients plus one), out_of_range (a reading that is
  /// not finite, a light or distance that is not above 0).
  [[nodiscard]] static Result<Linearisation> fit(std::span<const BenchReading> readings, int degree = 4);

  /// Metres; any finite light is allowed. No allocation.
  [[nodiscard]] double distance_m(double light) const;
  /// The light that distances are told between.
  [[nodiscard]] double dimmest() const { return dimmest_; }
  [[nodiscard]] double brightest() const { return brightest_; }

 private:
  double dimmest_ = 0;
  double brightest_ = 1;
  double centre_ = 0;  ///< Of the logarithm, so that the powers stay small.
  double scale_ = 1;
  std::vector<double> coefficients_;  ///< Ascending powers.
};

}  // namespace mien::eyewear
