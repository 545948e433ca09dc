#include "mien/headset/headset_camera.h"

#include <fmt/format.h>

#include <algorithm>

#include "mien/sensor/rig_part.h"

namespace mien::headset {
namespace {

constexpr int kQuarterTurn_deg = 90;

}  // namespace

bool is_inside_every_head(const Vec3& place_m) {
  static const Vec3 kMiddle_m(0, 0.03, 0), kHalfAxes_m(0.06, 0.08, 0.07);
  return (place_m - kMiddle_m).cwiseQuotient(kHalfAxes_m).squaredNorm() < 1;
}

NetworkViewSettings network_view_of(const sensor::PictureView& view, std::size_t side) {
  const auto& [left, top, width, height] = view.crop;
  return {.side = static_cast<int>(side),
          .left = left,
          .top = top,
          .right = std::min(1.0, left + width),
          .bottom = std::min(1.0, top + height),
          .quarter_turns = view.turn_deg / kQuarterTurn_deg,
          .mirror = view.mirror};
}

Result<std::vector<HeadsetCamera>> headset_cameras(const sensor::Rig& rig, std::size_t side) {
  const std::string where = "rig " + rig.name;
  std::vector<HeadsetCamera> cameras;
  for (const std::uint16_t number : sensor::sensors_of(rig, "camera")) {
    const sensor::Mount& mount = rig.sensors[number];
    if (!mount.camera)
      return fail(ErrorCode::mismatch, fmt::format("camera {} has no [sensor.camera]", mount.name), where,
                  "say what it looks at, as rigs/headset.toml does");
    if (mount.position_m && is_inside_every_head(*mount.position_m))
      return fail(ErrorCode::out_of_range, fmt::format("{} is inside the head", mount.name), where,
                  "give it a position_m before the face, in metres, frame H");
    const sensor::CameraMount& camera = *mount.camera;
    const std::size_t place = (mount.site == "mouth" ? 2U : 0U) + (mount.side == 'R' ? 1U : 0U);
    const auto other = std::ranges::find(cameras, place, &HeadsetCamera::place);
    if (other != cameras.end())
      return fail(ErrorCode::mismatch,
                  fmt::format("{} and {} look at the same, and the network has one place for it", other->name,
                              mount.name),
                  where, "leave one of them out, or give them sides L and R");
    cameras.push_back({.sensor = number,
                       .place = place,
                       .name = mount.name,
                       .view = network_view_of(sensor::view_of(camera), side),
                       .half_exposure = from_seconds(camera.exposure_ms / 2000)});
  }
  if (cameras.empty()) return fail(ErrorCode::mismatch, "no sensor of this rig is of the kind camera", where);
  return cameras;
}

}  // namespace mien::headset
