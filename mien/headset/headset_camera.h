#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/core/time.h"
#include "mien/headset/network_view.h"
#include "mien/sensor/picture_view.h"
#include "mien/sensor/rig.h"

namespace mien::headset {

/// A camera of a rig as the network knows it.
struct HeadsetCamera {
  std::uint16_t sensor = 0;  ///< Its number in the rig.
  std::size_t place = 0;     ///< Below model::kViews.
  std::string name;          ///< In the rig.
  NetworkViewSettings view;  ///< What of its pictures the network sees.
  Duration half_exposure{};  ///< From the middle of a picture's exposure to its end.
};

/// What of its pictures the network sees of a camera, in a view of `side` pixels either way.
[[nodiscard]] NetworkViewSettings network_view_of(const sensor::PictureView& view, std::size_t side);

/// Whether a place (frame H) lies inside whatever head: within an ellipsoid that the built-in family's skins
/// contain. One that does not may still be inside the head of somebody.
[[nodiscard]] bool is_inside_every_head(const Vec3& place_m);

/// The cameras of a rig, in its order, for a network whose views have `side` pixels either way. One before
/// the middle of the face stands for the left. Errors: mismatch (no camera; one without a [sensor.camera];
/// two for one place); out_of_range (one inside every head).
[[nodiscard]] Result<std::vector<HeadsetCamera>> headset_cameras(const sensor::Rig& rig, std::size_t side);

}  // namespace mien::headset
