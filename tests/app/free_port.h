#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>

namespace mien::app::test {

/// A UDP port of loopback on which nobody listens now.
inline std::uint16_t free_port() {
  boost::asio::io_context network;
  const boost::asio::ip::udp::endpoint any(boost::asio::ip::address_v4::loopback(), 0);
  return boost::asio::ip::udp::socket(network, any).local_endpoint().port();
}

}  // namespace mien::app::test
