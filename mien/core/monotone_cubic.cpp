#include "mien/core/monotone_cubic.h"

#include <cstddef>

namespace mien {

void monotone_slopes(std::span<const double> time_s, std::span<const float> value, std::span<float> slope) {
  const std::size_t n = time_s.size();
  if (n == 0) return;
  slope[0] = 0;
  slope[n - 1] = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before_s = time_s[i] - time_s[i - 1];
    const double after_s = time_s[i + 1] - time_s[i];
    const double before = (static_cast<double>(value[i]) - value[i - 1]) / before_s;
    const double after = (static_cast<double>(value[i + 1]) - value[i]) / after_s;
    if (before * after <= 0) {
      slope[i] = 0;
      continue;
    }
    const double w1 = 2 * after_s + before_s;
    const double w2 = after_s + 2 * before_s;
    slope[i] = static_cast<float>((w1 + w2) / (w1 / before + w2 / after));
  }
}

float hermite(double t0, float y0, float m0, double t1, float y1, float m1, double t) {
  const double h = t1 - t0;
  const double u = (t - t0) / h;
  const double u2 = u * u;
  const double u3 = u2 * u;
  return static_cast<float>((2 * u3 - 3 * u2 + 1) * y0 + (u3 - 2 * u2 + u) * h * m0 + (3 * u2 - 2 * u3) * y1 +
                            (u3 - u2) * h * m1);
}

}  // namespace mien
