#include "tests/live/page_client.h"

#include "mien/live/page_server.h"

#include <gmock/gmock.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <future>
#include <optional>
#include <span>

namespace mien::live::page_server_test {
namespace {

using namespace std::string_literals;
using boost::asio::ip::tcp;
using test::PageClient;
using test::run_until;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kToken = "abcd1234efgh";

class PageServerTest : public ::testing::Test {
 protected:
  void open(const std::string& token = {}) {
    const auto bytes = [](std::string_view text) { return std::as_bytes(std::span(text)); };
    PageSettings settings{.host = "127.0.0.1", .port = 0, .token = token, .assets = {}};
    settings.assets.push_back({"/index.html", "text/html; charset=utf-8", bytes("<p>page</p>")});
    settings.assets.push_back({"/face.glb", "model/gltf-binary", bytes("glTF"), false});
    settings.assets.push_back({"/late.glb", "model/gltf-binary", {}, true, [this] { return late; }});
    auto made = PageServer::open(
        network, settings, [] { return std::string(R"({"type": "hello"})"); },
        [this](std::uint64_t client, std::string_view text) {
          received.emplace_back(text);
          server->send(client, R"({"type": "reply", "id": 0})");
        },
        [this](std::uint64_t, std::span<const std::byte> piece) { pieces.push_back(piece.size()); });
    ASSERT_TRUE(made) << made.error().message();
    server = *std::move(made);
    port = test::port_of(server->address());
  }

  std::string answer(const std::string& request) { return mien::test::answer(network, port, request); }
  std::string get(const std::string& target, const std::string& host = "127.0.0.1",
                  const std::string& method = "GET") {
    return answer(method + " " + target + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  }
  /// What a WebSocket's upgrade is answered with.
  int upgrade(const std::string& target, const std::map<std::string, std::string>& headers = {}) {
    PageClient client(network, port, target, headers);
    EXPECT_TRUE(run_until(network, [&] { return client.ended() || !client.messages().empty(); }));
    return client.status();
  }

  boost::asio::io_context network;
  std::promise<Result<std::vector<std::byte>>> making;
  std::shared_future<Result<std::vector<std::byte>>> late = making.get_future().share();
  std::vector<std::string> received;
  std::vector<std::size_t> pieces;  // Bytes of each binary message.
  std::unique_ptr<PageServer> server;
  std::uint16_t port = 0;
};

TEST_F(PageServerTest, GivesItsFilesAndNothingElse) {
  open();
  for (const char* target : {"/", "/index.html", "/?x=1"}) {
    const std::string text = get(target);
    EXPECT_THAT(text, StartsWith("HTTP/1.1 200")) << target;
    EXPECT_THAT(text, HasSubstr("<p>page</p>")) << target;
    EXPECT_THAT(text, HasSubstr("Content-Security-Policy: default-src 'self'")) << target;
    EXPECT_THAT(text, HasSubstr("nosniff")) << target;
  }
  EXPECT_THAT(get("/face.glb"), HasSubstr("glTF"));
  EXPECT_THAT(get("/index.html", "127.0.0.1", "HEAD"), Not(HasSubstr("<p>")));
  for (const char* target : {"/nothing", "/../../etc/passwd", "/%2e%2e/etc/passwd", "//etc/passwd",
                             "/index.html/", "/ws", "http://127.0.0.1/index.html", "*"})
    EXPECT_THAT(get(target), StartsWith("HTTP/1.1 404")) << target;
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS"})
    EXPECT_THAT(get("/", "127.0.0.1", method), StartsWith("HTTP/1.1 405")) << method;
  EXPECT_EQ(answer("nonsense\r\n\r\n"), "");
  EXPECT_EQ(answer("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + std::string(20000, 'x') + "\r\n\r\n"), "");
}

TEST_F(PageServerTest, GivesWhatIsStillBeingMadeOnceItIs) {
  open();
  std::string late_answer;
  bool ended = false;
  tcp::socket socket(network);
  socket.connect({boost::asio::ip::address_v4::loopback(), port});
  boost::asio::write(
      socket, boost::asio::buffer("GET /late.glb HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"s));
  boost::asio::async_read(socket, boost::asio::dynamic_buffer(late_answer),
                          [&](boost::system::error_code, std::size_t) { ended = true; });
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));  // Others need not wait for it.
  EXPECT_FALSE(ended);
  making.set_value(std::vector(4, std::byte{'x'}));
  EXPECT_TRUE(run_until(network, [&] { return ended; }));
  EXPECT_THAT(late_answer, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("\r\n\r\nxxxx")));
  EXPECT_THAT(get("/late.glb"), HasSubstr("\r\n\r\nxxxx"));
}

TEST_F(PageServerTest, SaysWhatCouldNotBeMade) {
  making.set_value(fail(ErrorCode::malformed, "no face", "a.obj"));
  open();
  EXPECT_THAT(get("/late.glb"), AllOf(StartsWith("HTTP/1.1 500"), HasSubstr("a.obj: no face")));
}

TEST_F(PageServerTest, AnswersOnLoopbackOnlyWhoCallsItThat) {
  open();
  for (const char* host : {"127.0.0.1", "127.0.0.1:8740", "localhost", "localhost:8740", "[::1]:8740"})
    EXPECT_THAT(get("/", host), StartsWith("HTTP/1.1 200")) << host;
  for (const char* host :
       {"evil.example", "127.0.0.1.evil.example", "localhost.evil.example:8740", "192.168.1.7", "[::1", ""})
    EXPECT_THAT(get("/", host), StartsWith("HTTP/1.1 403")) << host;
  EXPECT_THAT(answer("GET / HTTP/1.1\r\nConnection: close\r\n\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_EQ(upgrade("/ws", {{"Host", "evil.example"}}), 403);
}

TEST_F(PageServerTest, OpensSocketsOnlyForItsOwnPagesAndPrograms) {
  open();
  const std::string here = "127.0.0.1:" + std::to_string(port);
  EXPECT_EQ(upgrade("/ws"), 101);
  EXPECT_EQ(upgrade("/ws", {{"Origin", "http://" + here}}), 101);
  for (const std::string origin : {"http://evil.example", "null", "http://127.0.0.1", "http://127.0.0.1:1",
                                   "http://evil.example:8740", "file://"})
    EXPECT_EQ(upgrade("/ws", {{"Origin", origin}}), 403) << origin;
  EXPECT_EQ(upgrade("/other"), 404);
}

TEST_F(PageServerTest, WantsItsTokenForAllThatTellsOfTheSession) {
  open(kToken);
  EXPECT_THAT(server->address(), HasSubstr(std::string("?token=") + kToken));
  const std::string token = std::string("?token=") + kToken;
  // The page's own files are anybody's, by any name.
  EXPECT_THAT(get("/", "studio.local:8740"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(get("/face.glb" + token), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(upgrade("/ws" + token), 101);
  EXPECT_EQ(upgrade("/ws?a=b&token=" + std::string(kToken)), 101);
  for (const std::string wrong : {"", "?token=", "?token=abcd1234efgi", "?token=abcd1234efg",
                                  "?token=abcd1234efghi", "?tokens=abcd1234efgh", "?x=abcd1234efgh"}) {
    EXPECT_THAT(get("/face.glb" + wrong), StartsWith("HTTP/1.1 403")) << wrong;
    EXPECT_EQ(upgrade("/ws" + wrong), 403) << wrong;
  }
  EXPECT_EQ(upgrade("/ws" + token, {{"Origin", "http://evil.example"}}), 403)
      << "a token is no leave for others";
}

TEST_F(PageServerTest, SpeaksToAllOrOneAndHearsThem) {
  open();
  PageClient one(network, port), two(network, port);
  EXPECT_TRUE(run_until(network, [&] { return !one.messages().empty() && !two.messages().empty(); }));
  EXPECT_EQ(one.messages().front()["type"], "hello");
  EXPECT_EQ(server->clients(), 2u);
  one.say("hear me");
  EXPECT_TRUE(run_until(network, [&] { return !one.last("reply").is_null(); }));
  EXPECT_EQ(received, std::vector<std::string>{"hear me"});
  EXPECT_TRUE(two.last("reply").is_null());
  server->send(R"({"type": "status"})");
  server->send_frame(R"({"type": "frame", "index": 5})");
  EXPECT_TRUE(run_until(network, [&] { return one.frames() == 1 && two.frames() == 1; }));
  EXPECT_FALSE(two.last("status").is_null());
  server->send(999, "nobody");
}

TEST_F(PageServerTest, TellsBinaryMessagesFromTexts) {
  open(kToken);
  PageClient stranger(network, port), guest(network, port, std::string("/ws?token=") + kToken);
  EXPECT_TRUE(run_until(network, [&] { return stranger.ended() && server->clients() == 1; }));
  const std::vector<std::byte> sound(40'000);
  guest.send(sound);
  guest.say("{}");
  guest.send(std::span(sound).first(3));
  EXPECT_TRUE(run_until(network, [&] { return pieces.size() == 2 && received.size() == 1; }));
  EXPECT_EQ(pieces, (std::vector<std::size_t>{40'000, 3}));
  EXPECT_TRUE(server->has(2) != server->has(1));
  guest.send(std::vector<std::byte>((1 << 16) + 1));
  EXPECT_TRUE(run_until(network, [&] { return guest.ended() && server->clients() == 0; }));
  EXPECT_EQ(pieces.size(), 2U);
}

TEST_F(PageServerTest, EndsWhoSaysTooMuchAndForgetsWhoGoes) {
  open();
  {
    PageClient loud(network, port), calm(network, port);
    EXPECT_TRUE(run_until(network, [&] { return server->clients() == 2; }));
    loud.say(std::string(1 << 16, 'x'));
    EXPECT_TRUE(run_until(network, [&] { return received.size() == 1; }));
    loud.say(std::string((1 << 16) + 1, 'x'));
    EXPECT_TRUE(run_until(network, [&] { return loud.ended(); }));
    EXPECT_EQ(received.size(), 1u);
    EXPECT_FALSE(calm.ended());
    EXPECT_TRUE(run_until(network, [&] { return server->clients() == 1; }));
  }
  EXPECT_TRUE(run_until(network, [&] { return server->clients() == 0; }));
  server->send_frame("{}");
}

TEST_F(PageServerTest, SaysWhyItCannotBegin) {
  open();
  const auto error_of = [&](PageSettings settings) {
    const auto made = PageServer::open(
        network, std::move(settings), [] { return std::string(); }, [](std::uint64_t, std::string_view) {});
    return made ? std::string() : made.error().message();
  };
  EXPECT_THAT(error_of({.host = "0.0.0.0", .port = 0, .token = {}, .assets = {}}), HasSubstr("token"));
  EXPECT_THAT(error_of({.host = "somebody", .port = 0, .token = {}, .assets = {}}),
              HasSubstr("no IP address"));
  EXPECT_THAT(error_of({.host = "127.0.0.1", .port = port, .token = {}, .assets = {}}), HasSubstr("--page"));
}

}  // namespace
}  // namespace mien::live::page_server_test
