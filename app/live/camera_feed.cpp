#include "app/live/camera_feed.h"

#include <utility>  // Before Asio 1.74, which forgets it.

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>

#include "mien/headset/picture_streams.h"
#include "mien/live/camera_stream.h"
#include "mien/sensor/bindings.h"
#include "mien/sensor/rig_part.h"

namespace mien::app {
namespace {

/// Between two looks at whether the session is over, and at how the camera is.
constexpr auto kCameraLook = std::chrono::milliseconds(50);
/// What a board's picture of 240 x 240 pixels has, bytes.
constexpr double kSmallPicture = 4400, kLargePicture = 9000;

HostTime steady_now() {
  return HostTime(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

/// Pictures are handed over by who reads them, so that none waits for a look.
void follow_camera(const live::CameraAddress& address, sensor::DeviceKey device, live::FeedPort& port) {
  boost::asio::io_context network(1);
  live::CameraStream camera(
      network, address, std::make_unique<headset::MjpegStream>(device),
      [&port](std::span<const std::byte> datagram, std::span<const std::byte> payload) {
        port.hand_over(datagram, payload);
      },
      steady_now);
  bool open = false;
  std::string problem;
  while (!port.stopped()) {
    network.run_for(kCameraLook);
    live::CameraStream::Status now = camera.status();
    if (now.open && !open) port.tell("camera", now.address + ": pictures come");
    if (!now.problem.empty() && now.problem != problem)
      port.tell("camera_lost", now.address + ": " + now.problem);
    open = now.open;
    problem = std::move(now.problem);
  }
  camera.close();
}

}  // namespace

bool is_camera(std::string_view address) {
  return address.starts_with("http:") || address.starts_with("https:");
}

Result<std::vector<live::Feed>> camera_feeds(const std::vector<std::string>& addresses,
                                             const sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  const std::vector<std::uint16_t> cameras = sensor::sensors_of(rig, "camera");
  std::vector<live::Feed> feeds;
  for (const std::string& text : addresses) {
    MIEN_TRY_ASSIGN(const live::CameraAddress address, live::parse_camera_address(text));
    const std::size_t number = feeds.size();
    if (number >= cameras.size())
      return fail(ErrorCode::bad_usage,
                  fmt::format("rig {} has {} cameras, and this is one more", rig.name, cameras.size()), text,
                  "name a rig that has it with --rig, as rigs/headset.toml");
    const auto device =
        std::ranges::find(bound, cameras[number], [](const auto& binding) { return binding.second; });
    if (device == bound.end())
      return fail(ErrorCode::bad_usage,
                  fmt::format("{} is bound to no device", rig.sensors[cameras[number]].name),
                  "rig " + rig.name, "give it a device of its own");
    feeds.push_back(
        {.name = address.source(),
         .run = [address, key = device->first](live::FeedPort& port) { follow_camera(address, key, port); },
         .heard = false});
  }
  return feeds;
}

PictureBytes picture_bytes_an_hour(const sensor::Rig& rig) {
  PictureBytes bytes;
  for (const std::uint16_t number : sensor::sensors_of(rig, "camera")) {
    if (!rig.sensors[number].camera) continue;
    const sensor::CameraMount& camera = *rig.sensors[number].camera;
    const double pixels = static_cast<double>(camera.size[0]) * camera.size[1] / (240.0 * 240.0);
    bytes.least += 3600 * camera.rate_hz * pixels * kSmallPicture;
    bytes.most += 3600 * camera.rate_hz * pixels * kLargePicture;
  }
  return bytes;
}

}  // namespace mien::app
