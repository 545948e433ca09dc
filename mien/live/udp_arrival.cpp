
#include "mien/live/udp_arrival.h"

#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "mien/live/network_interfaces.h"
#include "mien/sink/udp_target.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

/// Room for what the system tells of both families.
constexpr std::size_t kControlBytes = CMSG_SPACE(sizeof(in_pktinfo)) + CMSG_SPACE(sizeof(in6_pktinfo));

asio::ip::address address_of(const in_addr& address) {
  return asio::ip::address_v4(ntohl(address.s_addr));
}

asio::ip::address address_of(const in6_addr& address) {
  asio::ip::address_v6::bytes_type bytes;
  std::memcpy(bytes.data(), address.s6_addr, bytes.size());
  return asio::ip::address_v6(bytes);
}

/// Of fe80::1, which every interface may have once.
bool is_link_local(const asio::ip::address& address) {
  return address.is_v6() && address.to_v6().is_link_local();
}

bool is_of_this_machine(const asio::ip::address& address) {
  return !address.is_unspecified() && !address.is_multicast() && sink::is_this_machine(address);
}

}  // namespace

void tell_arrivals(udp::socket& socket) {
  const int yes = 1;
  const int descriptor = socket.native_handle();
  // What a socket is of, and where it is of both families the other too.
  static_cast<void>(::setsockopt(descriptor, IPPROTO_IP, IP_PKTINFO, &yes, sizeof(yes)));
  static_cast<void>(::setsockopt(descriptor, IPPROTO_IPV6, IPV6_RECVPKTINFO, &yes, sizeof(yes)));
}

std::optional<UdpArrival> receive_datagram(udp::socket& socket, std::span<std::byte> room,
                                           udp::endpoint& from) {
  alignas(cmsghdr) std::array<std::byte, kControlBytes> control{};
  iovec bytes{.iov_base = room.data(), .iov_len = room.size()};
  msghdr message{};
  message.msg_name = from.data();
  message.msg_namelen = static_cast<socklen_t>(from.capacity());
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  ssize_t size = -1;
  do {
    size = ::recvmsg(socket.native_handle(), &message, MSG_DONTWAIT);
  } while (size < 0 && errno == EINTR);
  if (size < 0) return std::nullopt;
  from.resize(message.msg_namelen);
  UdpArrival arrival{.size = static_cast<std::size_t>(size), .interface = 0, .address = {}};
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level == IPPROTO_IP && part->cmsg_type == IP_PKTINFO) {
      in_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(part), sizeof(info));
      arrival.interface = static_cast<unsigned>(info.ipi_ifindex);
      arrival.address = address_of(info.ipi_spec_dst);
      // The address in the datagram is another only where it is nobody's own.
      arrival.for_several = info.ipi_addr.s_addr != info.ipi_spec_dst.s_addr;
    } else if (part->cmsg_level == IPPROTO_IPV6 && part->cmsg_type == IPV6_PKTINFO) {
      in6_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(part), sizeof(info));
      // Of an IPv4 datagram the other part says more: whose address it is where it was broadcast.
      if (IN6_IS_ADDR_V4MAPPED(&info.ipi6_addr)) continue;
      arrival.interface = info.ipi6_ifindex;
      arrival.address = address_of(info.ipi6_addr);
      arrival.for_several = arrival.address.is_multicast();
    }
  }
  return arrival;
}

Result<UdpEntrance> UdpEntrance::find(std::string_view name) {
  UdpEntrance out;
  out.name_ = name;
  const auto none = [&out] {
    return fail(ErrorCode::bad_usage, "no interface and no address of this machine", out.name_.substr(0, 40),
                "name one that `ip address` shows");
  };
  boost::system::error_code code;
  asio::ip::address address = asio::ip::make_address(out.name_, code);
  if (code) {
    out.interface_ = out.name_;
    out.look_up();
    if (out.number_ == 0) return none();
    return out;
  }
  unsigned long zone = 0;
  if (address.is_v6()) {
    zone = address.to_v6().scope_id();
    // The parser takes a zone that is not here for none.
    if (zone == 0 && name.contains('%')) return none();
    address = asio::ip::address_v6(address.to_v6().to_bytes());
  }
  const auto all = network_interfaces();
  const auto its = std::ranges::find_if(all, [&](const NetworkInterface& one) {
    return one.address == address.to_string() && (zone == 0 || ::if_nametoindex(one.name.c_str()) == zone);
  });
  // No socket binds to a link-local one without its zone.
  if (its == all.end() && (zone != 0 || is_link_local(address) || !is_of_this_machine(address)))
    return none();
  if (its != all.end()) out.interface_ = its->name;
  out.address_ = address;
  out.look_up();
  return out;
}

void UdpEntrance::look_up() {
  if (interface_.empty() || interface_.size() >= IF_NAMESIZE) return;
  if (const unsigned number = ::if_nametoindex(interface_.c_str()); number != 0) number_ = number;
}

bool UdpEntrance::admits(const UdpArrival& arrival) const {
  const bool here = number_ != 0 && arrival.interface == number_;
  if (!address_) return here;
  if (arrival.for_several) return here && arrival.address.is_v6() == address_->is_v6();
  return arrival.address == *address_ && (here || !is_link_local(*address_));
}

}  // namespace mien::live
