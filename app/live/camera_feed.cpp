#include "app/live/camera_feed.h"

#include <utility>  // Before Asio 1.74, which forgets it.

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>

#include "mien/headset/headset_camera.h"
#include "mien/headset/picture_streams.h"
#include "mien/headset/view_maker.h"
#include "mien/live/camera_news.h"
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

/// A camera of the command line, and how it can be looked at.
struct FollowedCamera {
  live::CameraAddress address;
  std::string sensor;  ///< Its name in the rig.
  sensor::DeviceKey device;
  headset::ViewMaker views;
};

/// Pictures are handed over by who reads them, so that none waits for a look.
void follow_camera(FollowedCamera& followed, live::PictureTap& tap, live::FeedPort& port) {
  boost::asio::io_context network(1);
  live::CameraStream camera(
      network, followed.address, followed.sensor, std::make_unique<headset::MjpegStream>(followed.device),
      [&](std::span<const std::byte> datagram, std::span<const std::byte> payload) {
        port.hand_over(datagram, payload);
        tap.offer([&](const live::PictureTap::Wish& wish, std::span<std::uint8_t> pixels) {
          return followed.views.make(payload, headset::network_view_of(wish.part, live::PictureTap::kSide),
                                     pixels);
        });
      },
      steady_now);
  live::CameraNews news;
  while (!port.stopped()) {
    network.run_for(kCameraLook);
    live::CameraStatus now = camera.status();
    if (auto said = news.tell(steady_now(), now)) port.tell(std::move(said->kind), std::move(said->text));
    port.show(std::move(now));
  }
  camera.close();
}

}  // namespace

bool is_camera(std::string_view address) {
  return address.starts_with("http:") || address.starts_with("https:");
}

Result<ListenedCameras> listened_cameras(const std::vector<std::string>& listen, const sensor::Rig& rig) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  const std::vector<std::uint16_t> cameras = sensor::sensors_of(rig, "camera");
  ListenedCameras out;
  for (const std::string& text : listen) {
    const bool asked = is_camera(text);
    if (!asked && !text.starts_with("serial:")) continue;
    const std::size_t number = out.all.size();
    const bool there = number < cameras.size();
    if (asked && !there)
      return fail(ErrorCode::bad_usage,
                  fmt::format("rig {} has {} cameras, and this is one more", rig.name, cameras.size()), text,
                  "name a rig that has it with --rig, as rigs/headset.toml");
    if (!there) continue;
    const std::string& sensor = rig.sensors[cameras[number]].name;
    const auto device =
        std::ranges::find(bound, cameras[number], [](const auto& binding) { return binding.second; });
    if (asked && device == bound.end())
      return fail(ErrorCode::bad_usage, fmt::format("{} is bound to no device", sensor), "rig " + rig.name,
                  "give it a device of its own");
    if (device == bound.end()) continue;
    const sensor::DeviceKey key = device->first;
    std::string source;
    if (asked) {
      MIEN_TRY_ASSIGN(const live::CameraAddress address, live::parse_camera_address(text));
      source = address.source();
      MIEN_TRY_ASSIGN(headset::ViewMaker views, headset::ViewMaker::create());
      const auto camera = std::make_shared<FollowedCamera>(
          FollowedCamera{.address = address, .sensor = sensor, .device = key, .views = std::move(views)});
      const auto tap = std::make_shared<live::PictureTap>(key);
      out.feeds.push_back({.name = source,
                           .run = [camera, tap](live::FeedPort& port) { follow_camera(*camera, *tap, port); },
                           .heard = false,
                           .tap = tap});
    } else {
      MIEN_TRY_ASSIGN(const live::SerialAddress line, live::parse_serial_address(text));
      source = line.source();
      out.lines.emplace(text, live::LineCamera{sensor, std::make_unique<headset::EtvrStream>(key)});
    }
    out.all.emplace_back(std::move(source), sensor);
    out.sensors.push_back(cameras[number]);
  }
  return out;
}

PictureBytes picture_bytes_an_hour(const sensor::Rig& rig, const std::vector<std::uint16_t>& cameras) {
  PictureBytes bytes;
  for (const std::uint16_t number : cameras) {
    if (!rig.sensors[number].camera) continue;
    const sensor::CameraMount& camera = *rig.sensors[number].camera;
    const double pixels = static_cast<double>(camera.size[0]) * camera.size[1] / (240.0 * 240.0);
    bytes.least += 3600 * camera.rate_hz * pixels * kSmallPicture;
    bytes.most += 3600 * camera.rate_hz * pixels * kLargePicture;
  }
  return bytes;
}

}  // namespace mien::app
