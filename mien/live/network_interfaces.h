#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mien::live {

/// An address of this machine, and the interface that has it.
struct NetworkInterface {
  std::string name;     ///< "wlan0"
  std::string address;  ///< "192.168.1.7", "fe80::1": without brackets and zone.
  bool loopback = false;
  bool operator==(const NetworkInterface&) const = default;
};

/// Of every interface that is up, IPv4 and IPv6, in the machine's own order, but loopback's last. Empty where
/// the system does not tell. Cost: a few system calls, some ten microseconds an interface. Thread-safe.
[[nodiscard]] std::vector<NetworkInterface> network_interfaces();

/// Whether a port of this address ("udp://0.0.0.0:5005", "udp://[::]:5005") listens on every interface.
[[nodiscard]] bool is_on_every_interface(std::string_view listening);
/// Whether nobody but this machine reaches it: loopback's addresses, serial lines.
[[nodiscard]] bool is_on_this_machine(std::string_view listening);

/// Those of `all` by which a port of this address is reached: of 0.0.0.0 the IPv4 ones, of [::] all, of
/// another the one that has it. Empty for a serial line.
[[nodiscard]] std::vector<NetworkInterface> reached_by(std::string_view listening,
                                                       std::span<const NetworkInterface> all);

}  // namespace mien::live
