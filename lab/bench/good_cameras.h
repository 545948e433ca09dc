#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "lab/bench/clock.h"
#include "mien/core/error.h"
#include "mien/live/picture_server.h"

namespace mien::lab {

/// JPEGs as a camera of a headset takes them, each unlike the one before.
using Pictures = std::vector<std::vector<std::byte>>;
/// `count` pictures of 240 x 240 pixels.
[[nodiscard]] Pictures made_up_pictures(std::size_t count);

/// Cameras of this machine that do what they should, 60 pictures a second, each with a clock of its own, on a
/// thread of their own.
class GoodCameras {
 public:
  /// `pictures` outlive them. Errors: PictureServer::open's.
  [[nodiscard]] static Result<std::unique_ptr<GoodCameras>> open(const Pictures& pictures, std::size_t count);
  ~GoodCameras() { io_.stop(); }

  [[nodiscard]] std::string address(std::size_t camera) const;
  [[nodiscard]] bool are_all_watched() const;

 private:
  explicit GoodCameras(const Pictures& pictures) : pictures_(pictures) {}
  void show();

  const Pictures& pictures_;
  boost::asio::io_context io_{1};
  boost::asio::steady_timer timer_{io_};
  Clock::time_point begun_ = Clock::now();
  std::size_t number_ = 0;
  std::vector<std::unique_ptr<live::PictureServer>> servers_;
  std::jthread thread_;  // The last: it uses the others.
};

}  // namespace mien::lab
