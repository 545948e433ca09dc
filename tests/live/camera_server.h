#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.

#include <boost/asio.hpp>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <string_view>

namespace mien::live::test {

/// A small HTTP server on this machine's loopback, in the test's own io_context: what it answers each request
/// is up to the test.
class CameraServer {
 public:
  using tcp = boost::asio::ip::tcp;

  /// One who asked.
  struct Visitor {
    explicit Visitor(boost::asio::io_context& network) : socket(network) {}
    tcp::socket socket;
    std::string request;
    std::list<std::string> sending;

    /// All of it, in its turn.
    void send(std::string bytes) {
      sending.push_back(std::move(bytes));
      if (sending.size() == 1) send_next();
    }
    void hang_up() {
      boost::system::error_code ignored;
      socket.close(ignored);
    }

   private:
    void send_next() {
      boost::asio::async_write(socket, boost::asio::buffer(sending.front()),
                               [this](boost::system::error_code code, std::size_t) {
                                 sending.pop_front();
                                 if (!code && !sending.empty()) send_next();
                               });
    }
  };

  /// Port 0: any. `answer`: is called with each who has asked.
  CameraServer(boost::asio::io_context& network, std::uint16_t port, std::function<void(Visitor&)> answer)
      : network_(network),
        acceptor_(network, {boost::asio::ip::address_v4::loopback(), port}),
        answer_(std::move(answer)) {
    accept();
  }
  /// It is gone, and everybody's connection with it.
  void vanish() {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    for (Visitor& visitor : visitors) visitor.hang_up();
  }
  [[nodiscard]] std::uint16_t port() const { return port_; }

  std::list<Visitor> visitors;

 private:
  void accept() {
    Visitor& visitor = visitors.emplace_back(network_);
    acceptor_.async_accept(visitor.socket, [this, &visitor](boost::system::error_code code) {
      if (code) return visitors.pop_back();
      boost::asio::async_read_until(visitor.socket, boost::asio::dynamic_buffer(visitor.request), "\r\n\r\n",
                                    [this, &visitor](boost::system::error_code failed, std::size_t) {
                                      if (!failed) answer_(visitor);
                                    });
      accept();
    });
  }

  boost::asio::io_context& network_;
  tcp::acceptor acceptor_;
  std::uint16_t port_ = acceptor_.local_endpoint().port();
  std::function<void(Visitor&)> answer_;
};

}  // namespace mien::live::test
