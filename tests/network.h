#pragma once

#include <gtest/gtest.h>

#include <boost/asio.hpp>
#include <chrono>
#include <cstdint>
#include <string>

// A network in a test: what is waited for, and what a server answers to bytes.
namespace mien::test {

/// Lets the network work until `done`, and looks after it between; a minute at most.
template <class Done>
bool run_until(boost::asio::io_context& network, Done done) {
  // Without this it would end at once where it has nothing to do, and stay ended.
  const auto work = boost::asio::make_work_guard(network);
  network.restart();
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    network.run_one_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// What a server on this machine's port answers to these bytes, until it hangs up.
inline std::string answer(boost::asio::io_context& network, std::uint16_t port, const std::string& request) {
  boost::asio::ip::tcp::socket socket(network);
  socket.connect({boost::asio::ip::address_v4::loopback(), port});
  boost::system::error_code failed;
  boost::asio::write(socket, boost::asio::buffer(request), failed);
  std::string text;
  bool ended = false;
  boost::asio::async_read(socket, boost::asio::dynamic_buffer(text),
                          [&](boost::system::error_code, std::size_t) { ended = true; });
  EXPECT_TRUE(run_until(network, [&] { return ended; }));
  return text;
}

}  // namespace mien::test
