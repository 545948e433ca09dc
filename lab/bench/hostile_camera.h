#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "lab/bench/clock.h"
#include "mien/core/error.h"
#include "mien/core/random.h"
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

/// What a camera says next to one who asked it.
struct CameraTurn {
  std::string bytes;
  std::chrono::microseconds pause{};  ///< After them; 0: as fast as they are taken.
  bool hangs_up = false;              ///< After them.
};
/// One conversation, each call its next turn.
using CameraTalk = std::function<CameraTurn()>;

/// What hostile cameras do, each in the way in which it answers who asks. `pictures` outlive the
/// conversation.
[[nodiscard]] CameraTalk camera_endless_part(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_endless_head(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_flood(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_lying_lengths(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_trickle(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_turned_hostile(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_redirect(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_hangs_up(const Pictures& pictures, Random random);
[[nodiscard]] CameraTalk camera_wild_clock(const Pictures& pictures, Random random);

/// A camera on a free port of this machine's loopback that answers whoever asks with such a conversation, on
/// a thread of its own until its object's end.
class HostileCamera {
 public:
  using Begin = CameraTalk (*)(const Pictures& pictures, Random random);
  /// `pictures` outlive this. Throws boost::system::system_error where there is no port.
  HostileCamera(Begin talk, const Pictures& pictures, std::uint64_t seed);
  ~HostileCamera();
  [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  /// Bytes that have left so far.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  struct Visitor;
  void accept();
  void say(const std::shared_ptr<Visitor>& visitor);

  Begin talk_;
  const Pictures& pictures_;
  Random random_;
  std::uint64_t visitors_ = 0;
  boost::asio::io_context io_;
  boost::asio::ip::tcp::acceptor acceptor_;
  std::atomic<std::uint64_t> sent_ = 0;
  std::jthread thread_;  // The last: it uses the others.
};

}  // namespace mien::lab
