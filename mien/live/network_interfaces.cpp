#include "mien/live/network_interfaces.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <utility>

#include "mien/core/host_port.h"

namespace mien::live {
namespace {

/// Empty for an address of another family.
std::string address_text(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* number = nullptr;
  if (address.sa_family == AF_INET) number = &reinterpret_cast<const sockaddr_in&>(address).sin_addr;
  if (address.sa_family == AF_INET6) number = &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  if (number == nullptr || ::inet_ntop(address.sa_family, number, text.data(), text.size()) == nullptr)
    return {};
  return text.data();
}

/// The host of "udp://HOST:PORT", without brackets; empty for a serial line.
std::string_view host_in(std::string_view listening) {
  if (!listening.starts_with("udp://")) return {};
  const auto address = parse_host_port(listening.substr(6));
  return address ? address->host : std::string_view();
}

}  // namespace

std::vector<NetworkInterface> network_interfaces() {
  std::vector<NetworkInterface> all;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return all;
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owned(list, &::freeifaddrs);
  for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || (one->ifa_flags & IFF_UP) == 0) continue;
    std::string address = address_text(*one->ifa_addr);
    if (address.empty()) continue;
    const bool loopback = (one->ifa_flags & IFF_LOOPBACK) != 0;
    const auto place = loopback ? all.end() : std::ranges::find(all, true, &NetworkInterface::loopback);
    all.insert(place, {one->ifa_name, std::move(address), loopback});
  }
  return all;
}

bool is_on_every_interface(std::string_view listening) {
  const std::string_view host = host_in(listening);
  return host == "0.0.0.0" || host == "::";
}

bool is_on_this_machine(std::string_view listening) {
  return !listening.starts_with("udp://") || is_loopback(host_in(listening));
}

std::vector<NetworkInterface> reached_by(std::string_view listening, std::span<const NetworkInterface> all) {
  const std::string_view host = host_in(listening);
  std::vector<NetworkInterface> out;
  std::ranges::copy_if(all, std::back_inserter(out), [&](const NetworkInterface& one) {
    if (host == "0.0.0.0") return one.address.find(':') == std::string::npos;
    return host == "::" || one.address == host;
  });
  return out;
}

}  // namespace mien::live
