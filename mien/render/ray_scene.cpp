#include "mien/render/ray_scene.h"

#include <algorithm>
#include <stdexcept>

namespace mien::render {
namespace {

RTCRay ray_of(const Vec3f& origin, const Vec3f& direction, float from, float to) {
  return {.org_x = origin.x(),
          .org_y = origin.y(),
          .org_z = origin.z(),
          .tnear = from,
          .dir_x = direction.x(),
          .dir_y = direction.y(),
          .dir_z = direction.z(),
          .time = 0,
          .tfar = to,
          .mask = ~0U,
          .id = 0,
          .flags = 0};
}

}  // namespace

RayScene::RayScene(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles)
    // One thread builds: a tree of some ten thousand triangles takes milliseconds, and is the same every
    // time.
    : device_(rtcNewDevice("threads=1")) {
  if (!device_) throw std::runtime_error("Embree does not start on this processor");
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_ROBUST));
  // Only then does move() refit the mesh's tree. With a scene of higher quality Embree 3.13 builds all anew,
  // which takes thirty times as long and gives the same hits.
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_LOW);
  mesh_ = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  if (!triangles.empty()) {
    positions_ = static_cast<float*>(rtcSetNewGeometryBuffer(
        mesh_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), vertices.size()));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        mesh_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
    if (positions_ == nullptr || indices == nullptr)
      throw std::runtime_error("no memory for the mesh's ray tree");
    std::ranges::copy(std::span(vertices.data()->data(), 3 * vertices.size()), positions_);
    std::ranges::copy(std::span(triangles.data()->data(), 3 * triangles.size()), indices);
    rtcCommitGeometry(mesh_);
    rtcAttachGeometry(scene_.get(), mesh_);
  }
  rtcReleaseGeometry(mesh_);
  rtcCommitScene(scene_.get());
}

void RayScene::move(std::span<const Vec3f> vertices) {
  if (positions_ == nullptr) return;
  std::ranges::copy(std::span(vertices.data()->data(), 3 * vertices.size()), positions_);
  rtcSetGeometryBuildQuality(mesh_, RTC_BUILD_QUALITY_REFIT);
  rtcUpdateGeometryBuffer(mesh_, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(mesh_);
  rtcCommitScene(scene_.get());
}

RayScene::Hit RayScene::first_hit(const Vec3f& origin, const Vec3f& direction, float from) const {
  RTCRayHit ray{};
  ray.ray = ray_of(origin, direction, from, std::numeric_limits<float>::infinity());
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {.triangle = ray.hit.primID, .distance = ray.ray.tfar, .u = ray.hit.u, .v = ray.hit.v};
}

/// `ray(k)`: direction and end of the ray to the k-th.
template <class Ray>
void RayScene::blocked_each(const Vec3f& origin, float from, RTCIntersectContextFlags flags, const Ray& ray,
                            std::span<std::uint8_t> is_blocked) const {
  constexpr std::size_t kPacket = 16;
  if (positions_ == nullptr) {
    std::ranges::fill(is_blocked, std::uint8_t{0});
    return;
  }
  alignas(64) RTCRay16 rays;
  alignas(64) std::array<int, kPacket> valid;
  for (std::size_t first = 0; first < is_blocked.size(); first += kPacket) {
    const std::size_t count = std::min(kPacket, is_blocked.size() - first);
    for (std::size_t k = 0; k < kPacket; ++k) {
      const ToDirection to = ray(first + std::min(k, count - 1));
      valid[k] = k < count ? -1 : 0;
      rays.org_x[k] = origin.x();
      rays.org_y[k] = origin.y();
      rays.org_z[k] = origin.z();
      rays.tnear[k] = from;
      rays.dir_x[k] = to.direction.x();
      rays.dir_y[k] = to.direction.y();
      rays.dir_z[k] = to.direction.z();
      rays.time[k] = 0;
      rays.tfar[k] = to.to;
      rays.mask[k] = ~0U;
      rays.id[k] = 0;
      rays.flags[k] = 0;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = flags;
    rtcOccluded16(valid.data(), scene_.get(), &context, &rays);
    for (std::size_t k = 0; k < count; ++k) is_blocked[first + k] = rays.tfar[k] < 0 ? 1 : 0;
  }
}

void RayScene::blocked(const Vec3f& origin, std::span<const Vec3f> directions, float from, float to,
                       std::span<std::uint8_t> is_blocked) const {
  blocked_each(
      origin, from, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT,
      [&](std::size_t k) {
        return ToDirection{directions[k], to};
      },
      is_blocked.first(directions.size()));
}

void RayScene::blocked_towards(const Vec3f& origin, std::span<const Vec3f> targets_m, float short_m,
                               std::span<std::uint8_t> is_blocked) const {
  blocked_each(
      origin, 0, RTC_INTERSECT_CONTEXT_FLAG_COHERENT,
      [&](std::size_t k) {
        const Vec3f way = targets_m[k] - origin;
        const float length = way.norm();
        return ToDirection{way / std::max(length, 1e-6F), std::max(0.0F, length - short_m)};
      },
      is_blocked.first(targets_m.size()));
}

bool RayScene::blocked(const Vec3f& origin, const Vec3f& direction, float from, float to) const {
  RTCRay ray = ray_of(origin, direction, from, to);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar < 0;
}

}  // namespace mien::render
