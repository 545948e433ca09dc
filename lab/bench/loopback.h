#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.
//
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

namespace mien::lab {

/// A UDP socket on a free port of this machine's own address, for benchmarks. Throws
/// boost::system::system_error where there is none.
inline boost::asio::ip::udp::socket loopback(boost::asio::io_context& io) {
  using boost::asio::ip::udp;
  return udp::socket(io, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0));
}

}  // namespace mien::lab
