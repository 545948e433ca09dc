#pragma once

#include <cmath>
#include <concepts>

namespace mien {

/// The probability, 0 to 1, whose log odds these are: 1 / (1 + exp(-log_odds)).
template <std::floating_point Real>
[[nodiscard]] Real logistic(Real log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

}  // namespace mien
