#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

#include "lab/bench/hostile_camera.h"
#include "mien/core/random.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/worn_devices.h"

namespace mien::lab {

/// What a stranger hears on the air: the latest datagrams of the devices of a rig. Until there are any, what
/// such devices would say. Thread-safe.
class Overheard {
 public:
  explicit Overheard(const sensor::Rig& rig);
  void add(std::span<const std::byte> datagram);
  /// One of them.
  [[nodiscard]] std::vector<std::byte> draw(Random& random) const;

 private:
  static constexpr std::size_t kKept = 256;
  mutable std::mutex mutex_;
  std::vector<std::vector<std::byte>> datagrams_;
  std::size_t next_ = 0;  // The oldest of them, once there are kKept.
};

/// What a stranger says: the next datagram of one of his sockets, so many seconds after he began.
using Speech = std::function<std::vector<std::byte>(double time_s, std::size_t socket)>;

/// Whom a stranger takes for his victims.
struct Victims {
  const sensor::Rig& rig;  ///< Its virtual boards: sensor::virtual_device().
  const Overheard& overheard;
};

/// One way to attack a session. All senders but the devices are on addresses of their own.
struct Attack {
  enum class Begins { first, second };  ///< Before the devices say anything, or a second after they began.

  std::string_view name;
  std::string_view does;
  Begins begins = Begins::second;
  double rate_hz = 0;         ///< Datagrams a second, from all sockets together.
  std::size_t addresses = 1;  ///< The stranger's, ...
  std::size_t sockets = 1;    ///< ... and how many ports on each of them.
  Speech (*speech)(const Victims& victims, Random random) = nullptr;
  /// He behaves in every way as a sensor and speaks first: only a key or a choice on the page shuts him out.
  bool behaves = false;
  virt::NodeLanguage devices = virt::NodeLanguage::mien;  ///< What the attacked devices speak.
  /// Of a camera that the session asks, in place of `speech` and what goes with that; null: it is none.
  HostileCamera::Begin camera = nullptr;
};

/// All of them, in the table's order, cameras last.
[[nodiscard]] std::span<const Attack> attacks();

/// A stranger who attacks a session on this machine's loopback, on a thread of his own until his object's
/// end.
class Stranger {
 public:
  /// `attack` is no camera's. `rate`: share of the attack's own. The victims outlive this. Throws
  /// boost::system::system_error where the machine has not so many sockets.
  Stranger(const Attack& attack, std::uint16_t port, const Victims& victims, double rate, std::uint64_t seed);
  /// Datagrams that have left so far.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  void run(const std::stop_token& stop);

  double rate_hz_;
  boost::asio::ip::udp::endpoint to_;
  Speech speech_;
  boost::asio::io_context io_;
  std::vector<boost::asio::ip::udp::socket> sockets_;
  std::atomic<std::uint64_t> sent_ = 0;
  std::jthread thread_;  // The last: it uses the others.
};

/// A datagram with something wrong in it: bits turned over, its end cut off, or bytes behind it. Every second
/// time it ends with the checksum that our packets have, and it is right all the same, so that what lies
/// behind it is reached. Not empty.
[[nodiscard]] std::vector<std::byte> damaged(std::vector<std::byte> datagram, Random& random);

/// Its last bytes become the checksum of what stands before them; nothing of fewer bytes is changed.
void mend_checksum(std::vector<std::byte>& datagram);

}  // namespace mien::lab
