#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/headset/answer.h"

namespace mien::headset {

/// Corrects the directions that a network finds of one wearer's eyes: of each eye an affine map, the identity
/// where nothing is known. Angles as face::OutputFrame has them, rad.
struct GazeMap {
  using Affine = Eigen::Matrix<float, 2, 3>;  ///< Times (yaw, pitch, 1).
  std::array<Affine, 2> eyes = {Affine::Identity(), Affine::Identity()};

  [[nodiscard]] Eigen::Vector2f apply(std::size_t eye, const Eigen::Vector2f& found_rad) const {
    return eyes[eye] * found_rad.homogeneous();
  }
  /// The answer's directions so, held to kMostGaze_rad.
  void correct(Answer& answer) const;
  /// Of this one the gains alone: an offset is of the neutral and the seat in which it was learnt.
  [[nodiscard]] GazeMap gains() const;
  bool operator==(const GazeMap&) const = default;
};

/// What was found while a wearer looked at one target: the mean of each eye that was seen.
struct GazeSample {
  Eigen::Vector2f known_rad = Eigen::Vector2f::Zero();
  std::array<std::optional<Eigen::Vector2f>, 2> found_rad;
};

/// A map, and what it is worth. Of each eye the root mean square of the angles' errors at targets, rad.
struct GazeFit {
  GazeMap map;                       ///< The identity for an eye whose map was not kept.
  std::array<bool, 2> fitted{};      ///< The eye was seen at kLeastTargets; else nothing of it is known.
  std::array<bool, 2> kept{};        ///< The map is closer to targets that it was not fitted to than none is.
  std::array<double, 2> before{};    ///< Without a map.
  std::array<double, 2> held_out{};  ///< At each target, of a map fitted to the others.
};

/// Fits a map to samples, one a target, by ridge regression towards the identity: a direction that the
/// targets hardly tell stays as it was found. Each eye by itself; kept only if it helps at held-out targets,
/// leaving each out in turn, and turns nothing round (its gains between kLeastGain and kMostGain). Errors:
/// out_of_range (no eye was seen at kLeastTargets, numbers that are not finite).
[[nodiscard]] Result<GazeFit> fit_gaze_map(std::span<const GazeSample> samples);

inline constexpr std::size_t kLeastTargets = 4;
inline constexpr double kLeastGain = 0.3;
inline constexpr double kMostGain = 3;

/// JSON, {"gaze": ...}: of the left and the right eye six numbers, row by row; parse_gaze_map takes it back,
/// whatever else stands beside it. Errors:
/// malformed, out_of_range (numbers beyond kMostGain, offsets beyond 1.1 rad).
[[nodiscard]] std::string write_gaze_map(const GazeMap& map);
[[nodiscard]] Result<GazeMap> parse_gaze_map(std::string_view json, const std::string& where);

}  // namespace mien::headset
