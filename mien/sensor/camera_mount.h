#pragma once

#include <array>
#include <vector>

#include "mien/core/rotation.h"

namespace mien::sensor {

/// A light-emitting diode of a headset. Every lamp lights what every camera sees.
struct Lamp {
  Vec3 position_m = Vec3::Zero();  ///< Built-in head, frame H.
  Vec3 aim = -Vec3::UnitZ();       ///< Where it shines most (unit), frame H.
  double power_mw = 10;            ///< Radiant. Raising: brighter pictures, or shorter exposures.
  double half_angle_deg = 60;      ///< So far off its aim it shines half as bright. Raising: evener light.
  bool operator==(const Lamp&) const = default;
};

/// How a camera of a headset looks at the face, and which part of its pictures the network sees. It stands at
/// Mount::position_m; on other heads than the built-in one the headset keeps its shape. Its site is "eye" or
/// "mouth".
struct CameraMount {
  Vec3 look_at_m = Vec3::Zero();      ///< In the middle of the picture, built-in head, frame H.
  Vec3 up = Vec3::UnitY();            ///< Up in the picture (unit), frame H; not along the line of sight.
  double field_of_view_deg = 80;      ///< Of the longer side, whole angle, as if the lens were straight.
  double radial_k1 = 0;               ///< Lens: a tangent r is shown at r (1 + k1 r^2); barrels below 0.
  std::array<int, 2> size{240, 240};  ///< Width and height, pixels.
  double rate_hz = 60;                ///< Pictures a second.
  double exposure_ms = 4;             ///< Of a picture, which shows the face in its middle.
  std::array<double, 4> crop{0, 0, 1, 1};  ///< Left, top, width, height of what the network sees, as shares
                                           ///< of the picture as it comes.
  int turn_deg = 0;                        ///< Then it is turned clockwise by this: 0, 90, 180, 270.
  bool mirror = false;                     ///< Then left and right change places.
  std::vector<Lamp> lamps;                 ///< Beside this camera; up to 8.
  bool operator==(const CameraMount&) const = default;
};

}  // namespace mien::sensor
