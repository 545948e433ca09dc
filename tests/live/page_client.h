#pragma once

#include <utility>  // Before Asio 1.74, which forgets it.

#include <gtest/gtest.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/network.h"

// A browser's part of the page's protocol, by another than our own code.
namespace mien::live::test {

using mien::test::run_until;

/// A WebSocket to a page server. Whoever calls runs the network, with run_until.
class PageClient {
 public:
  PageClient(boost::asio::io_context& network, std::uint16_t port, const std::string& target = "/ws",
             const std::map<std::string, std::string>& headers = {})
      : network_(network), stream_(network), host_("127.0.0.1:" + std::to_string(port)) {
    namespace websocket = boost::beast::websocket;
    stream_.set_option(websocket::stream_base::decorator([headers](websocket::request_type& request) {
      for (const auto& [name, value] : headers) request.set(name, value);
    }));
    stream_.read_message_max(1 << 24);
    const boost::asio::ip::tcp::endpoint there(boost::asio::ip::address_v4::loopback(), port);
    stream_.next_layer().async_connect(there, [this, target](boost::system::error_code code) {
      if (code) return end();
      stream_.async_handshake(answer_, host_, target, [this](boost::system::error_code failed) {
        if (failed) return end();
        read();
      });
    });
  }
  PageClient(const PageClient&) = delete;
  PageClient& operator=(const PageClient&) = delete;
  /// Goes as a browser that is killed does.
  ~PageClient() {
    boost::system::error_code ignored;
    stream_.next_layer().close(ignored);
    run_until(network_, [this] { return ended_; });
  }

  /// Sends a text; the answer is among the messages, later.
  void say(std::string text) {
    stream_.text(true);
    write(std::as_bytes(std::span(text)));
  }
  /// Sends a binary message.
  void send(std::span<const std::byte> bytes) {
    stream_.binary(true);
    write(bytes);
  }
  /// Sends a command; returns its reply, or null when the connection ends first.
  nlohmann::json ask(nlohmann::json command) {
    const std::int64_t number = ++number_;
    command["id"] = number;
    say(command.dump());
    nlohmann::json reply;
    EXPECT_TRUE(run_until(network_, [&] {
      for (const nlohmann::json& message : messages_)
        if (message["type"] == "reply" && message["id"] == number) reply = message;
      return !reply.is_null() || ended_;
    })) << command;
    return reply;
  }

  /// All texts but frames, in order.
  [[nodiscard]] const std::vector<nlohmann::json>& messages() const { return messages_; }
  /// Binary messages, in order.
  [[nodiscard]] const std::vector<std::string>& binary() const { return binary_; }
  [[nodiscard]] std::size_t frames() const { return frames_; }
  [[nodiscard]] const nlohmann::json& last_frame() const { return last_frame_; }
  /// The newest of this type, or null.
  [[nodiscard]] nlohmann::json last(std::string_view type) const {
    for (auto message = messages_.rbegin(); message != messages_.rend(); ++message)
      if ((*message)["type"] == type) return *message;
    return nullptr;
  }
  [[nodiscard]] bool has_event(std::string_view kind) const {
    for (const nlohmann::json& message : messages_)
      if (message["type"] == "event" && message["kind"] == kind) return true;
    return false;
  }
  /// The connection is no more, or never was.
  [[nodiscard]] bool ended() const { return ended_; }
  /// Of the answer to the upgrade: 101, 403; 0 when none came.
  [[nodiscard]] int status() const { return static_cast<int>(answer_.result_int()); }

 private:
  void end() { ended_ = true; }
  void write(std::span<const std::byte> bytes) {
    EXPECT_TRUE(run_until(network_, [this] { return stream_.is_open() || ended_; }));
    bool written = false;
    stream_.async_write(boost::asio::buffer(bytes.data(), bytes.size()),
                        [&](boost::system::error_code, std::size_t) { written = true; });
    EXPECT_TRUE(run_until(network_, [&] { return written; }));
  }
  void read() {
    stream_.async_read(buffer_, [this](boost::system::error_code code, std::size_t) {
      if (code) return end();
      std::string bytes = boost::beast::buffers_to_string(buffer_.data());
      buffer_.consume(buffer_.size());
      if (stream_.got_binary()) {
        binary_.push_back(std::move(bytes));
        return read();
      }
      nlohmann::json message = nlohmann::json::parse(bytes, nullptr, false);
      if (message.is_object() && message["type"] == "frame") {
        ++frames_;
        last_frame_ = std::move(message);
      } else {
        messages_.push_back(std::move(message));
      }
      read();
    });
  }

  boost::asio::io_context& network_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> stream_;
  std::string host_;
  boost::beast::websocket::response_type answer_;
  boost::beast::flat_buffer buffer_;
  std::vector<nlohmann::json> messages_;
  std::vector<std::string> binary_;
  nlohmann::json last_frame_;
  std::size_t frames_ = 0;
  std::int64_t number_ = 0;
  bool ended_ = false;
};

/// The port in "http://127.0.0.1:8740/?token=..." or "udp://127.0.0.1:5005".
inline std::uint16_t port_of(const std::string& address) {
  return static_cast<std::uint16_t>(
      std::stoi(address.substr(address.find(':', address.find("://") + 3) + 1)));
}

}  // namespace mien::live::test
