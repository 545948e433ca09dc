#pragma once

// Asio 1.74 uses std::exchange without including this.
#include <utility>
//
#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <string>
#include <vector>

namespace mien::sink::test {

/// Somebody on this machine who receives datagrams on a port of their own.
class Receiver {
 public:
  explicit Receiver(boost::asio::io_context& network)
      : socket_(network, {boost::asio::ip::address_v4::loopback(), 0}) {
    socket_.non_blocking(true);
    socket_.set_option(boost::asio::socket_base::receive_buffer_size(1 << 20));
  }
  [[nodiscard]] std::uint16_t port() const { return socket_.local_endpoint().port(); }
  boost::asio::ip::udp::socket& socket() { return socket_; }
  /// All that has come. On this machine's own loopback what was sent is there when send returns.
  std::vector<std::string> take() {
    std::vector<std::string> packets;
    for (;;) {
      std::string packet(65536, '\0');
      boost::system::error_code code;
      const std::size_t size = socket_.receive(boost::asio::buffer(packet), 0, code);
      if (code) return packets;
      packet.resize(size);
      packets.push_back(std::move(packet));
    }
  }

 private:
  boost::asio::ip::udp::socket socket_;
};

}  // namespace mien::sink::test
