#pragma once

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::live {

/// Where a datagram came in.
struct UdpArrival {
  std::size_t size = 0;    ///< Of the datagram; the room's where it was cut.
  unsigned interface = 0;  ///< The system's number of it; 0: the system does not tell.
  /// The machine's address that it was for, without a zone; of a broadcast one of the interface's.
  /// Unspecified: not told.
  boost::asio::ip::address address;
  bool for_several = false;  ///< It was broadcast or multicast.
};

/// Asks the system to tell where a socket's datagrams come in.
void tell_arrivals(boost::asio::ip::udp::socket& socket);
/// The next datagram of a socket that does not block; none: nothing is there. No allocation.
[[nodiscard]] std::optional<UdpArrival> receive_datagram(boost::asio::ip::udp::socket& socket,
                                                         std::span<std::byte> room,
                                                         boost::asio::ip::udp::endpoint& from);

/// One way into this machine: an interface, or an address that one of its interfaces has.
class UdpEntrance {
 public:
  /// Of "wlan0" or "192.168.1.7"; of a link-local IPv6 address, with its zone ("fe80::1%wlan0") or without,
  /// the interface that has it. Errors: bad_usage (neither is here).
  [[nodiscard]] static Result<UdpEntrance> find(std::string_view name);

  [[nodiscard]] const std::string& name() const { return name_; }
  /// None for an interface.
  [[nodiscard]] const std::optional<boost::asio::ip::address>& address() const { return address_; }
  /// An interface that was plugged in again has another number: looks it up. One system call.
  void look_up();
  /// Whether it came in here. By an address also what was for several machines, and came to its interface.
  [[nodiscard]] bool admits(const UdpArrival& arrival) const;

 private:
  std::string name_;
  std::string interface_;  // Whose number is meant; empty where it is not known.
  unsigned number_ = 0;
  std::optional<boost::asio::ip::address> address_;  // Without a zone.
};

}  // namespace mien::live
