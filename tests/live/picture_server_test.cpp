#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/picture_server.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <boost/asio.hpp>
#include <memory>
#include <string>
#include <vector>

#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_streams.h"
#include "mien/live/camera_stream.h"
#include "tests/headset/small_jpeg.h"
#include "tests/network.h"

namespace mien::live::picture_server_test {
namespace {

using headset::test::Bytes;
using mien::test::run_until;
using tcp = boost::asio::ip::tcp;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr sensor::DeviceKey kCamera{.device = 0x024D49484401};

class PictureServerTest : public ::testing::Test {
 protected:
  void open(PictureServer::Settings settings = {}) {
    server = PictureServer::open(network, settings).value();
  }
  /// What one who says this is answered, until the server hangs up or `enough`.
  std::string answer_to(const std::string& request, const std::function<bool(const std::string&)>& enough) {
    tcp::socket socket(network);
    socket.connect({boost::asio::ip::address_v4::loopback(), server->port()});
    boost::asio::write(socket, boost::asio::buffer(request));
    std::string answer;
    std::array<char, 4096> bytes{};
    bool over = false;
    std::function<void()> read = [&] {
      socket.async_read_some(boost::asio::buffer(bytes), [&](boost::system::error_code code, std::size_t n) {
        answer.append(bytes.data(), n);
        over = over || code;
        if (!code) read();
      });
    };
    read();
    EXPECT_TRUE(run_until(network, [&] { return over || enough(answer); })) << answer;
    boost::system::error_code ignored;
    socket.close(ignored);
    run_until(network, [&] { return over; });
    return answer;
  }
  void TearDown() override {
    server.reset();
    network.restart();
    network.poll();
  }

  boost::asio::io_context network;
  std::unique_ptr<PictureServer> server;
  const Bytes jpeg = headset::test::grey_jpeg(40, 40, 1);
};

TEST_F(PictureServerTest, IsReadByACameraStream) {
  open({.rate_hz = 30});
  std::vector<headset::PicturePacket> packets;
  std::vector<Bytes> pictures;
  const auto stream_to = [&](bool keep) {
    return std::make_unique<CameraStream>(
        network, parse_camera_address(fmt::format("http://127.0.0.1:{}", server->port())).value(), "eye_L",
        std::make_unique<headset::MjpegStream>(kCamera),
        [&, keep](std::span<const std::byte> datagram, std::span<const std::byte> payload) {
          if (!keep) return;
          packets.push_back(headset::parse_picture_packet(datagram).value());
          pictures.emplace_back(payload.begin(), payload.end());
        },
        [] { return HostTime(std::chrono::steady_clock::now().time_since_epoch()); });
  };
  const auto one = stream_to(true), other = stream_to(false);
  ASSERT_TRUE(run_until(network, [&] { return server->counts().clients == 2; }));
  for (int i = 0; i < 5; ++i)
    server->send(DeviceTime(std::chrono::microseconds(99'999'999 + 16'667 * i)), jpeg);
  ASSERT_TRUE(
      run_until(network, [&] { return pictures.size() == 5 && other->status().pictures.whole == 5; }));
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(pictures[i], jpeg);
    EXPECT_EQ(packets[i],
              (headset::PicturePacket{.from = kCamera,
                                      .sequence = i,
                                      .time = DeviceTime(std::chrono::microseconds(99'999'999 + 16'667 * i)),
                                      .first = i == 0}));
  }
  EXPECT_EQ(one->status().pictures, sensor::StreamCounts{.whole = 5});
  EXPECT_EQ(server->counts().pictures, 5U);
  EXPECT_EQ(server->counts().dropped, 0U);
  // One who leaves is nobody's loss.
  other->close();
  ASSERT_TRUE(run_until(network, [&] { return server->counts().clients == 1; })) << "without a picture";
  server->send(DeviceTime(std::chrono::seconds(200)), jpeg);
  ASSERT_TRUE(run_until(network, [&] { return pictures.size() == 6; }));
  one->close();
}

TEST_F(PictureServerTest, SpeaksWithTheBoardsHeaders) {
  open({.rate_hz = 59.9});
  bool sent = false;
  const std::string answer =
      answer_to("GET /stream HTTP/1.1\r\nHost: x\r\n\r\n", [&](const std::string& so_far) {
        if (!sent && server->counts().clients == 1) {
          sent = true;
          server->send(DeviceTime(std::chrono::microseconds(12'000'034)), jpeg);
        }
        return so_far.size() > jpeg.size() + 300;
      });
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: "
                                "multipart/x-mixed-replace;boundary=123456789000000000000987654321\r\n"));
  EXPECT_THAT(answer, HasSubstr("X-Framerate: 60\r\n"));
  EXPECT_THAT(answer, HasSubstr("--123456789000000000000987654321\r\n"));
  EXPECT_THAT(answer, HasSubstr(fmt::format("Content-Type: image/jpeg\r\nContent-Length: {}\r\n"
                                            "X-Timestamp: 12.000034\r\n\r\n",
                                            jpeg.size())));
}

TEST_F(PictureServerTest, DropsWhoIsTooSlowAndNobodyElse) {
  open({.most_waiting = 4});
  // Reads nothing.
  tcp::socket slow(network);
  slow.connect({boost::asio::ip::address_v4::loopback(), server->port()});
  slow.set_option(boost::asio::socket_base::receive_buffer_size(4096));
  boost::asio::write(slow, boost::asio::buffer(std::string("GET / HTTP/1.1\r\n\r\n")));
  CameraStream quick(
      network, parse_camera_address(fmt::format("http://127.0.0.1:{}", server->port())).value(), "eye_L",
      std::make_unique<headset::MjpegStream>(kCamera), [](auto, auto) {},
      [] { return HostTime(std::chrono::steady_clock::now().time_since_epoch()); });
  ASSERT_TRUE(run_until(network, [&] { return server->counts().clients == 2; }));
  const Bytes large(100'000, std::byte{1});  // No picture, but for the network.
  ASSERT_TRUE(run_until(network, [&] {
    server->send({}, large);
    for (int i = 0; i < 20; ++i) network.poll();
    return server->counts().dropped > 0;
  }));
  EXPECT_EQ(server->counts().dropped, 1U);
  EXPECT_EQ(server->counts().clients, 1U);
  EXPECT_TRUE(quick.status().bytes > 0);
  quick.close();
}

TEST_F(PictureServerTest, AnswersNothingButGet) {
  open();
  const auto over = [](const std::string& answer) { return answer.ends_with("\r\n\r\n"); };
  EXPECT_THAT(answer_to("DELETE / HTTP/1.1\r\n\r\n", over), StartsWith("HTTP/1.1 405 "));
  const auto never = [](const std::string&) { return false; };
  EXPECT_EQ(answer_to("nonsense\r\n\r\n", never), "");
  EXPECT_EQ(answer_to("GET / HTTP/1.1\r\nX: " + std::string(9000, 'a'), never), "");
  EXPECT_EQ(server->counts().clients, 0U);
}

TEST_F(PictureServerTest, TellsThatItsPortIsTaken) {
  open();
  const auto second = PictureServer::open(network, {.port = server->port()});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::io);
  EXPECT_THAT(second.error().message(), HasSubstr(fmt::format("127.0.0.1:{}: ", server->port())));
  EXPECT_EQ(PictureServer::open(network, {.host = "no.such.host.invalid"}).error().code,
            ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::live::picture_server_test
