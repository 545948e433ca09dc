#include "mien/sink/udp_target.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>

namespace mien::sink {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;
namespace error = boost::asio::error;

Delivery delivery(const error_code& code) {
  if (!code) return Delivery::taken;
  if (code == error::connection_refused || code == error::host_unreachable ||
      code == error::network_unreachable)
    return Delivery::refused;
  if (code == error::would_block || code == error::try_again || code == error::no_buffer_space)
    return Delivery::no_room;
  return Delivery::unsupported;
}

}  // namespace

std::string_view describe(Delivery what) {
  static constexpr std::array<std::string_view, 4> kWords = {
      "", "nobody listens there", "this machine's network has no room; frames are left out",
      "this machine's network refuses the packets"};
  return kWords.at(static_cast<std::size_t>(what));
}

Result<boost::asio::ip::address> find_host(boost::asio::io_context& network, const Address& address,
                                           std::uint16_t default_port) {
  udp::resolver resolver(network);
  error_code code;
  const auto found =
      resolver.resolve(address.host, std::to_string(address.port == 0 ? default_port : address.port), code);
  if (code || found.empty())
    return fail(ErrorCode::not_found, fmt::format("the host '{}' is not found", address.host),
                address.endpoint(default_port), "check the name, or write its number");
  const auto v4 = std::find_if(found.begin(), found.end(),
                               [](const auto& entry) { return entry.endpoint().address().is_v4(); });
  return (v4 == found.end() ? found.begin() : v4)->endpoint().address();
}

bool is_this_machine(const boost::asio::ip::address& address) {
  try {
    boost::asio::io_context nothing;
    udp::socket socket(nothing);
    error_code code;
    socket.open(address.is_v6() ? udp::v6() : udp::v4(), code);
    if (!code) socket.bind({address, 0}, code);
    return !code;
  } catch (const boost::system::system_error&) {  // No descriptor is left for a context.
    return false;
  }
}

Result<UdpTarget> UdpTarget::open(boost::asio::io_context& network, const Address& address,
                                  std::uint16_t default_port) {
  MIEN_TRY_ASSIGN(const auto host, find_host(network, address, default_port));
  return open(network, udp::endpoint(host, address.port == 0 ? default_port : address.port));
}

Result<UdpTarget> UdpTarget::open(boost::asio::io_context& network, const udp::endpoint& endpoint) {
  udp::socket socket(network);
  error_code code;
  const auto failed = [&](const char* what) {
    return fail(ErrorCode::io, fmt::format("{}: {}", what, code.message()),
                fmt::format("{}:{}", endpoint.address().to_string(), endpoint.port()));
  };
  if (socket.open(endpoint.protocol(), code)) return failed("no UDP socket");
  if (socket.non_blocking(true, code)) return failed("no UDP socket that does not block");
  if (socket.set_option(boost::asio::socket_base::broadcast(true), code)) return failed("no broadcasts");
  if (socket.connect(endpoint, code)) return failed("there is no way there");
  return UdpTarget(std::move(socket), endpoint);
}

Delivery UdpTarget::news() noexcept {
  int pending = 0;
  socklen_t size = sizeof(pending);
  if (::getsockopt(socket_.native_handle(), SOL_SOCKET, SO_ERROR, &pending, &size) != 0)
    return Delivery::taken;
  return delivery(error_code(pending, boost::system::system_category()));
}

Delivery UdpTarget::send(const Datagrams& datagrams) noexcept {
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    error_code code;
    const auto bytes = datagrams[i];
    socket_.send(boost::asio::buffer(bytes.data(), bytes.size()), 0, code);
    if (code) return delivery(code);
  }
  return Delivery::taken;
}

}  // namespace mien::sink
