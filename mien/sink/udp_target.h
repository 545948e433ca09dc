#pragma once

// Asio 1.74 uses std::exchange without including this.
#include <utility>
//
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

#include "mien/core/error.h"
#include "mien/sink/address.h"
#include "mien/sink/datagrams.h"

namespace mien::sink {

/// What the network said of a datagram.
enum class Delivery {
  taken,        ///< It is on its way; whether it arrives is not told.
  refused,      ///< Nobody listens on that port, or there is no way to that machine.
  no_room,      ///< The machine has no room for more just now.
  unsupported,  ///< Anything else: too large, no permission.
};
/// A few words for Status::note; empty for `taken`.
[[nodiscard]] std::string_view describe(Delivery delivery);

/// Where a host is: IPv4 before IPv6 where a name has both. Blocks while the name is looked up. Errors:
/// not_found.
[[nodiscard]] Result<boost::asio::ip::address> find_host(boost::asio::io_context& network,
                                                         const Address& address, std::uint16_t default_port);

/// Whether this machine has the address: a socket may be bound to no other. Also 127.0.0.2, which no
/// interface names.
[[nodiscard]] bool is_this_machine(const boost::asio::ip::address& address);

/// A UDP receiver, resolved once. Its socket is connected, so that the receiver's refusals come back.
class UdpTarget {
 public:
  /// Errors: find_host()'s, io.
  [[nodiscard]] static Result<UdpTarget> open(boost::asio::io_context& network, const Address& address,
                                              std::uint16_t default_port);
  /// The same for a receiver that is known by number. Errors: io.
  [[nodiscard]] static Result<UdpTarget> open(boost::asio::io_context& network,
                                              const boost::asio::ip::udp::endpoint& endpoint);

  /// What became of the datagrams before: `refused` when a refusal has come back since the last call.
  [[nodiscard]] Delivery news() noexcept;
  /// Hands datagrams over, all of them or those before the first that is not taken. Never blocks.
  [[nodiscard]] Delivery send(const Datagrams& datagrams) noexcept;
  [[nodiscard]] const boost::asio::ip::udp::endpoint& endpoint() const { return endpoint_; }

 private:
  explicit UdpTarget(boost::asio::ip::udp::socket socket, const boost::asio::ip::udp::endpoint& endpoint)
      : socket_(std::move(socket)), endpoint_(endpoint) {}

  boost::asio::ip::udp::socket socket_;
  boost::asio::ip::udp::endpoint endpoint_;
};

}  // namespace mien::sink
