#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "mien/core/error.h"
#include "mien/sensor/camera_mount.h"

namespace mien::sensor {

/// Which part of a camera's pictures the network sees, and how it is turned: what CameraMount has of it.
struct PictureView {
  std::array<double, 4> crop{0, 0, 1, 1};  ///< CameraMount::crop, and so on.
  int turn_deg = 0;
  bool mirror = false;
  bool operator==(const PictureView&) const = default;
};

/// What is to be another; the rest stays as it is.
struct PictureViewChange {
  std::optional<std::array<double, 4>> crop;
  std::optional<int> turn_deg;
  std::optional<bool> mirror;
  bool operator==(const PictureViewChange&) const = default;
};

/// Less of a picture, of its width or height, is no view of it.
inline constexpr double kLeastCrop = 0.05;

[[nodiscard]] PictureView view_of(const CameraMount& camera);
void set_view(CameraMount& camera, const PictureView& view);

/// Errors: out_of_range (it leaves the picture, too little is left of it, or it is no number), told of
/// `where`.
[[nodiscard]] Result<void> check_crop(const std::array<double, 4>& crop, const std::string& where);
/// Errors: out_of_range (neither 0, 90, 180 nor 270), told of `where`.
[[nodiscard]] Result<void> check_turn(std::int64_t turn_deg, const std::string& where);
/// The view after a change. Errors: check_crop's, check_turn's.
[[nodiscard]] Result<PictureView> changed_view(PictureView view, const PictureViewChange& change,
                                               const std::string& where);

}  // namespace mien::sensor
