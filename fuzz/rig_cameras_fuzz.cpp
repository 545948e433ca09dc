#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>
#include <vector>

#include "mien/headset/headset_camera.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/rig_views.h"

// What a rig says of its cameras is what a network can see by: of every camera that was accepted a view of a
// small picture is made, whose numbers are 0 to 1; and it can be given another view in the file's text.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kSide = 16;
  const auto rig =
      mien::sensor::parse_rig(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!rig) return 0;
  const auto cameras = mien::headset::headset_cameras(*rig, kSide);
  if (!cameras) return 0;
  constexpr int kWidth = 9, kHeight = 7;
  std::array<std::uint8_t, static_cast<std::size_t>(kWidth * kHeight)> pixels{};
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(37 * i);
  std::vector<float> seen(kSide * kSide);
  for (const mien::headset::HeadsetCamera& camera : *cameras) {
    if (camera.half_exposure < mien::Duration::zero()) std::abort();
    auto view = mien::headset::NetworkView::create(camera.view);
    if (!view) std::abort();
    view->make({.width = kWidth, .height = kHeight, .pixels = pixels}, seen);
    for (const float level : seen)
      if (!(level >= 0 && level <= 1)) std::abort();
    // Another view is written into the text as it stands, or refused.
    const mien::sensor::SensorView other{
        .sensor = camera.name, .view = {.crop = {0.2, 0.1, 0.5, 0.6}, .turn_deg = 90, .mirror = true}};
    const auto text =
        mien::sensor::with_views({reinterpret_cast<const char*>(data), size}, std::span(&other, 1), "input");
    if (!text) continue;
    const auto back = mien::sensor::parse_rig(*text, "input");
    if (!back || mien::sensor::view_of(*back->sensors[camera.sensor].camera) != other.view) std::abort();
  }
  return 0;
}
