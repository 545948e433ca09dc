#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>

#include "mien/core/rotation.h"

namespace mien::render {

/// Triangles that rays can be shot at: Embree behind a few functions. Vertices may move, triangles may not.
/// Rays may be shot from several threads; moving excludes shooting.
class RayScene {
 public:
  struct Hit {
    std::uint32_t triangle = 0;  ///< Index into the triangles given.
    float distance = std::numeric_limits<float>::infinity();
    float u = 0, v = 0;  ///< Weights of the second and third corner.
    [[nodiscard]] bool any() const { return distance < std::numeric_limits<float>::infinity(); }
  };

  RayScene(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles);

  void move(std::span<const Vec3f> vertices);
  [[nodiscard]] Hit first_hit(const Vec3f& origin, const Vec3f& direction, float from = 0) const;

  /// Of each direction (unit) from `origin`: 1 where something stands between the distances `from` and `to`,
  /// else 0. Shape: `is_blocked` beside `directions`. Many at once are cheaper than one by one.
  void blocked(const Vec3f& origin, std::span<const Vec3f> directions, float from, float to,
               std::span<std::uint8_t> is_blocked) const;
  [[nodiscard]] bool blocked(const Vec3f& origin, const Vec3f& direction, float from, float to) const;
  /// Of each target: 1 where something stands between `origin` and a place `short_m` before it, else 0.
  /// Shape: `is_blocked` beside `targets_m`. Targets close to each other in the list are cheaper.
  void blocked_towards(const Vec3f& origin, std::span<const Vec3f> targets_m, float short_m,
                       std::span<std::uint8_t> is_blocked) const;

 private:
  struct ToDirection {
    Vec3f direction = Vec3f::UnitZ();  // Unit.
    float to = 0;
  };
  template <class Ray>
  void blocked_each(const Vec3f& origin, float from, RTCIntersectContextFlags flags, const Ray& ray,
                    std::span<std::uint8_t> is_blocked) const;

  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene_;
  RTCGeometry mesh_ = nullptr;  // Owned by scene_.
  float* positions_ = nullptr;  // Owned by mesh_.
};

}  // namespace mien::render
