#pragma once

#include <numbers>

/// Factors between SI and the units that people and other programs use. A value in degrees times kRadPerDeg
/// is in radians.
namespace mien {

inline constexpr double kRadPerDeg = std::numbers::pi / 180;
inline constexpr double kDegPerRad = 180 / std::numbers::pi;
inline constexpr double kMmPerM = 1000;
/// Standard gravity, m/s^2 (ISO 80000-3).
inline constexpr double kStandardGravity_m_s2 = 9.80665;

}  // namespace mien
