#pragma once

#include <span>

namespace mien {

/// Slopes of the monotone piecewise cubic through (time_s, value): no overshoot between samples.
/// Shape: all three of equal size n >= 1, time_s strictly increasing.
/// Source: Fritsch and Butland 1984, doi:10.1137/0905021 (harmonic mean of the neighbouring secants).
void monotone_slopes(std::span<const double> time_s, std::span<const float> value, std::span<float> slope);

/// Value at time t between (t0, y0, slope m0) and (t1, y1, slope m1); t0 < t1.
[[nodiscard]] float hermite(double t0, float y0, float m0, double t1, float y1, float m1, double t);

}  // namespace mien
