#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::headset {

/// Where to look for a calibration: yaw to the performer's left and pitch upwards, rad.
struct GazeTarget {
  std::string_view name;  ///< As a prompt is called.
  Eigen::Vector2f angles_rad;
};
/// Ahead, left, right, up, down: far enough apart to tell a gain, near enough for a screen and for lids.
[[nodiscard]] std::span<const GazeTarget> gaze_targets();

/// Corrects the directions that a network finds of one wearer's eyes: of each eye an affine map, the identity
/// where nothing is known. Angles as face::OutputFrame has them, rad.
struct GazeMap {
  using Affine = Eigen::Matrix<float, 2, 3>;  ///< Times (yaw, pitch, 1).
  std::array<Affine, 2> eyes = {Affine::Identity(), Affine::Identity()};

  [[nodiscard]] Eigen::Vector2f apply(std::size_t eye, const Eigen::Vector2f& found_rad) const {
    return eyes[eye] * found_rad.homogeneous();
  }
  bool operator==(const GazeMap&) const = default;
};

/// What was found while a wearer looked at one target: the mean of each eye.
struct GazeSample {
  Eigen::Vector2f known_rad = Eigen::Vector2f::Zero();
  std::array<Eigen::Vector2f, 2> found_rad = {Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()};
};

/// A map, and what it is worth. Of each eye the root mean square of the angles' errors at targets, rad.
struct GazeFit {
  GazeMap map;                       ///< The identity for an eye whose map was not kept.
  std::array<bool, 2> kept{};        ///< The map is closer to targets that it was not fitted to than none is.
  std::array<double, 2> before{};    ///< Without a map.
  std::array<double, 2> held_out{};  ///< At each target, of a map fitted to the others.
};

/// Fits a map to samples, one a target, by ridge regression towards the identity: a direction that the
/// targets hardly tell stays as it was found. Each eye by itself; kept only if it helps at held-out targets,
/// leaving each out in turn, and turns nothing round (its gains between kLeastGain and kMostGain). Errors:
/// out_of_range (fewer than kLeastTargets samples, numbers that are not finite).
[[nodiscard]] Result<GazeFit> fit_gaze_map(std::span<const GazeSample> samples);

inline constexpr std::size_t kLeastTargets = 4;
inline constexpr double kLeastGain = 0.3;
inline constexpr double kMostGain = 3;

/// JSON: of the left and the right eye six numbers, row by row; parse_gaze_map takes it back. Errors:
/// malformed, out_of_range (numbers beyond kMostGain, offsets beyond 1.1 rad).
[[nodiscard]] std::string write_gaze_map(const GazeMap& map);
[[nodiscard]] Result<GazeMap> parse_gaze_map(std::string_view json, const std::string& where);

}  // namespace mien::headset
