#include "mien/sink/sink_kinds.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/network.h"
#include "tests/sink/loopback.h"

namespace mien::sink::ws_sink_test {
namespace {

using boost::asio::ip::tcp;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::json;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using mien::test::answer;
using mien::test::run_until;

/// A port of this machine on which nobody listens.
std::uint16_t free_port() {
  boost::asio::io_context network;
  tcp::acceptor acceptor(network, {boost::asio::ip::address_v4::loopback(), 0});
  return acceptor.local_endpoint().port();
}

std::string upgrade(const std::string& target, const std::string& headers) {
  return "GET " + target +
         " HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         headers + "\r\n";
}

/// A client that is not ours, on a thread of its own, which blocks.
class Client {
 public:
  explicit Client(std::uint16_t port, std::string target = "/", std::string origin = "")
      : thread_([this, port, target = std::move(target), origin = std::move(origin)] {
          try {
            websocket::stream<tcp::socket> stream(network_);
            stream.next_layer().connect({boost::asio::ip::address_v4::loopback(), port});
            if (!origin.empty())
              stream.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
                request.set(beast::http::field::origin, origin);
              }));
            stream.handshake("localhost", target);
            for (;;) {
              beast::flat_buffer buffer;
              stream.read(buffer);
              const std::scoped_lock lock(mutex_);
              messages_.push_back(beast::buffers_to_string(buffer.data()));
            }
          } catch (const std::exception&) {
          }
          ended_ = true;
        }) {}
  ~Client() { thread_.join(); }
  std::vector<std::string> messages() {
    const std::scoped_lock lock(mutex_);
    return messages_;
  }
  [[nodiscard]] bool ended() const { return ended_; }

 private:
  boost::asio::io_context network_;
  std::mutex mutex_;
  std::vector<std::string> messages_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

std::unique_ptr<Sink> opened(boost::asio::io_context& network, const std::string& address) {
  auto sink = open_sink(network, address);
  EXPECT_TRUE(sink) << sink.error().message();
  return sink ? *std::move(sink) : nullptr;
}

TEST(WsSink, ServesAllWhoConnect) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto sink = opened(network, fmt::format("ws://127.0.0.1:{}", port));
  ASSERT_TRUE(sink);
  EXPECT_THAT(sink->status().note, HasSubstr("waiting"));
  sink->send({}, 0);  // Nobody is there, which is no failure.
  EXPECT_EQ(sink->status().failed, 0u);
  {
    Client one(port);
    Client two(port, "/any/path", "http://localhost:8740");
    ASSERT_TRUE(run_until(network, [&] { return sink->status().receivers == 2; }));
    EXPECT_EQ(sink->status().note, "");
    face::OutputFrame frame;
    frame.weights[26] = 0.5F;
    std::int64_t index = 0;
    EXPECT_TRUE(run_until(network, [&] {
      sink->send(frame, ++index);
      return one.messages().size() > 10 && two.messages().size() > 10;
    }));
    for (Client* client : {&one, &two}) {
      const auto messages = client->messages();
      EXPECT_EQ(Json::parse(messages[0]).at("type"), "hello");
      EXPECT_THAT(Json::parse(messages[0]).at("software").get<std::string>(), StartsWith("mien "));
      std::int64_t last = 0;
      for (std::size_t i = 1; i < messages.size(); ++i) {
        const Json message = Json::parse(messages[i]);
        EXPECT_EQ(message.at("type"), "frame");
        EXPECT_EQ(message.at("weights")[26], 0.5);
        EXPECT_GT(message.at("index"), last);
        last = message.at("index");
      }
    }
    sink.reset();  // They are hung up on.
    EXPECT_TRUE(run_until(network, [&] { return one.ended() && two.ended(); }));
  }
}

TEST(WsSink, RefusesPagesOfOthersAndPlainRequests) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto sink = opened(network, fmt::format("ws://127.0.0.1:{}", port));
  ASSERT_TRUE(sink);
  EXPECT_THAT(answer(network, port, upgrade("/", "Origin: http://evil.example\r\n")),
              StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(answer(network, port, "GET / HTTP/1.1\r\nHost: a\r\n\r\n"), StartsWith("HTTP/1.1 426"));
  EXPECT_EQ(sink->status().receivers, 0u);
}

TEST(WsSink, SurvivesNonsense) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto sink = opened(network, fmt::format("ws://127.0.0.1:{}", port));
  ASSERT_TRUE(sink);
  for (const std::string& nonsense :
       {std::string("\0\1\2\3\r\n\r\n", 8), std::string(20'000, 'A'),
        std::string("GET / HTTP/1.1\r\nA: ") + std::string(20'000, 'b'),
        std::string("GET / HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: upgrade\r\n\r\n")})
    EXPECT_THAT(answer(network, port, nonsense), ::testing::Not(HasSubstr("101"))) << nonsense.substr(0, 40);
  Client good(port);
  EXPECT_TRUE(run_until(network, [&] { return sink->status().receivers == 1; }));
  sink.reset();
  EXPECT_TRUE(run_until(network, [&] { return good.ended(); }));
}

TEST(WsSink, TakesNoMoreThanItsCap) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto sink = opened(network, fmt::format("ws://127.0.0.1:{}", port));
  ASSERT_TRUE(sink);
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t i = 0; i < kMaxWsClients + 3; ++i) clients.push_back(std::make_unique<Client>(port));
  const auto ended = [&] {
    return std::ranges::count_if(clients, [](const auto& client) { return client->ended(); });
  };
  EXPECT_TRUE(run_until(network, [&] { return ended() == 3 && sink->status().receivers == kMaxWsClients; }));
  sink.reset();
  EXPECT_TRUE(run_until(network, [&] { return ended() == static_cast<std::ptrdiff_t>(clients.size()); }));
}

/// A reader that does not read gets few frames and the latest, and costs the others none.
TEST(WsSink, KeepsNoQueueForSlowReaders) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto sink = opened(network, fmt::format("ws://127.0.0.1:{}", port));
  ASSERT_TRUE(sink);
  tcp::socket slow(network);
  slow.open(tcp::v4());
  slow.set_option(boost::asio::socket_base::receive_buffer_size(4096));
  slow.connect({boost::asio::ip::address_v4::loopback(), port});
  boost::asio::write(slow,
                     boost::asio::buffer(std::string("GET / HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\n"
                                                     "Connection: upgrade\r\nSec-WebSocket-Version: 13\r\n"
                                                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n")));
  ASSERT_TRUE(run_until(network, [&] { return sink->status().receivers == 1; }));
  face::OutputFrame frame;
  constexpr std::int64_t kFrames = 6000;
  for (std::int64_t i = 1; i <= kFrames; ++i) {
    frame.weights[0] = static_cast<float>(i % 7) / 7;
    sink->send(frame, i);
    network.poll();
  }
  const Status status = sink->status();
  EXPECT_EQ(status.sent + status.failed, static_cast<std::uint64_t>(kFrames));
  EXPECT_LT(status.sent, 300u);
  // It reads again: after what was on its way comes the latest.
  std::string text;
  std::array<char, 65536> piece;
  bool reading = true;
  std::function<void()> read = [&] {
    slow.async_read_some(boost::asio::buffer(piece), [&](boost::system::error_code code, std::size_t size) {
      if (code) {
        reading = false;
        return;
      }
      text.append(piece.data(), size);
      read();
    });
  };
  read();
  EXPECT_TRUE(run_until(
      network, [&] { return text.find(fmt::format("\"index\":{},", kFrames)) != std::string::npos; }));
  EXPECT_LT(text.size(), 600'000u);
  sink.reset();
  EXPECT_TRUE(run_until(network, [&] { return !reading; }));
}

TEST(WsSink, WantsATokenOnTheNetwork) {
  boost::asio::io_context network;
  const auto port = free_port();
  const auto refused = open_sink(network, fmt::format("ws://0.0.0.0:{}", port));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("?token="));
  EXPECT_FALSE(open_sink(network, fmt::format("ws://0.0.0.0:{}?token=short", port)));
  auto sink = opened(network, fmt::format("ws://0.0.0.0:{}?token=abcd1234", port));
  ASSERT_TRUE(sink);
  EXPECT_THAT(answer(network, port, upgrade("/", "")), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(answer(network, port, upgrade("/?token=abcd1235", "")), StartsWith("HTTP/1.1 401"));
  Client with(port, "/?token=abcd1234");
  EXPECT_TRUE(run_until(network, [&] { return sink->status().receivers == 1; }));
  sink.reset();
  EXPECT_TRUE(run_until(network, [&] { return with.ended(); }));
}

/// Where somebody listens it connects; here that is a sink of ours, whose role is settled already.
TEST(WsSink, ConnectsToWhoListensAndTriesAgain) {
  boost::asio::io_context network;
  const auto port = free_port();
  const std::string address = fmt::format("ws://127.0.0.1:{}?token=abcd1234", port);
  auto server = opened(network, address);
  auto client = opened(network, address);
  ASSERT_TRUE(server && client);
  std::int64_t index = 0;
  const auto both = [&] {
    client->send({}, index++);
    return client->status().receivers == 1 && server->status().receivers == 1;
  };
  EXPECT_TRUE(run_until(network, both));
  EXPECT_TRUE(run_until(network, [&] {
    client->send({}, index++);
    return client->status().sent > 10;
  }));
  server.reset();
  EXPECT_TRUE(run_until(network, [&] {
    client->send({}, index++);
    return client->status().receivers == 0;
  }));
  EXPECT_THAT(client->status().note, HasSubstr("trying again"));
  const auto failed = client->status().failed;
  client->send({}, index++);
  EXPECT_EQ(client->status().failed, failed + 1);
  server = opened(network, address);
  EXPECT_TRUE(run_until(network, both));
  client.reset();
  server.reset();
}

/// Before the first frame it is known whether anybody is there, and once somebody is, they are called.
TEST(WsSink, CallsBeforeThereAreFrames) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto client = opened(network, fmt::format("ws://127.0.0.1:{}?role=connect", port));
  ASSERT_TRUE(client);
  EXPECT_EQ(client->status().note, "connecting");
  EXPECT_TRUE(run_until(network, [&] { return client->status().note != "connecting"; }));
  EXPECT_THAT(client->status().note, HasSubstr("no WebSocket answers there"));
  auto server = opened(network, fmt::format("ws://127.0.0.1:{}?role=listen", port));
  EXPECT_TRUE(run_until(network, [&] { return client->status().receivers == 1; }));
  EXPECT_EQ(client->status().note, "");
  EXPECT_EQ(client->status().sent + client->status().failed, 0u);
  client.reset();
  server.reset();
  network.restart();
  network.run_for(std::chrono::seconds(10));
  EXPECT_TRUE(network.stopped());  // Nothing waits any more.
}

TEST(WsSink, TakesARoleThatItIsGiven) {
  boost::asio::io_context network;
  const auto port = free_port();
  auto one = opened(network, fmt::format("ws://127.0.0.1:{}?role=listen", port));
  const auto two = open_sink(network, fmt::format("ws://127.0.0.1:{}?role=listen", port));
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().message(), HasSubstr("cannot listen"));
  EXPECT_FALSE(open_sink(network, fmt::format("ws://127.0.0.1:{}?role=dance", port)));
  auto lonely = opened(network, fmt::format("ws://127.0.0.1:{}?role=connect", free_port()));
  ASSERT_TRUE(lonely);
  lonely->send({}, 0);
  network.poll();
  EXPECT_EQ(lonely->status().failed, 1u);
  EXPECT_EQ(lonely->status().receivers, 0u);
}

}  // namespace
}  // namespace mien::sink::ws_sink_test
