#include "lab/bench/good_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "mien/render/jpeg.h"

namespace mien::lab {
namespace {

constexpr double kCameraHz = 60;
constexpr int kPixels = 240;
constexpr int kQuality = 80;

}  // namespace

Pictures made_up_pictures(std::size_t count) {
  Pictures all;
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(kPixels * kPixels));
  for (std::size_t n = 0; n < count; ++n) {
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x < kPixels; ++x) {
        const double distance = std::hypot(x - 70.0 - static_cast<double>(n), y - 120.0);
        grey[static_cast<std::size_t>(y * kPixels + x)] =
            static_cast<std::uint8_t>(128 + 90 * std::cos(distance / 6));
      }
    all.push_back(render::encode_jpeg(kPixels, kPixels, render::JpegPixels::grey, kQuality, grey).value());
  }
  return all;
}

Result<std::unique_ptr<GoodCameras>> GoodCameras::open(const Pictures& pictures, std::size_t count) {
  std::unique_ptr<GoodCameras> made(new GoodCameras(pictures));
  for (std::size_t c = 0; c < count; ++c) {
    MIEN_TRY_ASSIGN(made->servers_.emplace_back(), live::PictureServer::open(made->io_, {}));
  }
  made->show();
  made->thread_ = std::jthread([&cameras = *made] { cameras.io_.run(); });
  return made;
}

std::string GoodCameras::address(std::size_t camera) const {
  return fmt::format("http://127.0.0.1:{}/", servers_[camera]->port());
}

bool GoodCameras::are_all_watched() const {
  return std::ranges::all_of(servers_, [](const auto& server) { return server->counts().clients > 0; });
}

void GoodCameras::show() {
  const auto since = from_seconds(static_cast<double>(number_) / kCameraHz);
  timer_.expires_at(begun_ + std::chrono::duration_cast<Clock::duration>(since));
  timer_.async_wait([this, since](boost::system::error_code code) {
    if (code) return;
    for (std::size_t c = 0; c < servers_.size(); ++c)
      servers_[c]->send(DeviceTime(std::chrono::floor<std::chrono::microseconds>(
                            since + from_seconds(5.0 + 3.0 * static_cast<double>(c)))),
                        pictures_[(number_ + 7 * c) % pictures_.size()]);
    ++number_;
    show();
  });
}

}  // namespace mien::lab
