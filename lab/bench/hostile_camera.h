#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "lab/bench/good_cameras.h"
#include "mien/core/random.h"

namespace mien::lab {

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
