#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/camera_stream.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_streams.h"
#include "mien/live/payload_source.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"
#include "tests/live/camera_server.h"
#include "tests/network.h"

namespace mien::live::camera_stream_test {
namespace {

using headset::test::Bytes;
using mien::test::run_until;
using test::CameraServer;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr sensor::DeviceKey kCamera{.device = 0x024D49484401};

TEST(CameraAddress, IsReadAsPeopleTypeIt) {
  const auto source = [](const char* text) {
    const auto address = parse_camera_address(text);
    EXPECT_TRUE(address) << text;
    return address ? address->source() : std::string();
  };
  EXPECT_EQ(source("http://192.168.1.7"), "http://192.168.1.7/");
  EXPECT_EQ(source("http://192.168.1.7:80/"), "http://192.168.1.7/");
  EXPECT_EQ(source("http://openiristracker.local:81/stream?fps=60"),
            "http://openiristracker.local:81/stream?fps=60");
  EXPECT_EQ(source("http://OpenIris.local/Stream"), "http://openiris.local/Stream");
  EXPECT_EQ(source("http://[::1]:8081/a/b"), "http://[::1]:8081/a/b");
  EXPECT_EQ(parse_camera_address("http://[::1]:8081/a/b")->host, "::1");
  for (const std::string text :
       {"http://", "http:///path", "http://:80/", "https://host/", "ftp://host/", "host:80/",
        "http://host:0/", "http://host:65536/", "http://host:x/", "http://user:word@host/", "http://ho st/",
        "http://host/a b", "http://host/a\r\nX: y", "http://host/#part", "http://host\n/", "http://::1/",
        "http://[::1/", ""}) {
    const auto address = parse_camera_address(text);
    ASSERT_FALSE(address) << text;
    EXPECT_EQ(address.error().code, ErrorCode::bad_usage) << text;
    EXPECT_THAT(address.error().message(), HasSubstr("http://HOST:PORT/PATH"));
  }
  EXPECT_FALSE(parse_camera_address("http://host/" + std::string(100, 'a')));
}

class CameraStreamTest : public ::testing::Test {
 protected:
  using Visitor = CameraServer::Visitor;

  void start_server(std::function<void(Visitor&)> answer, std::uint16_t port = 0) {
    server.emplace(network, port, std::move(answer));
  }
  void start_camera(std::uint16_t port, const std::string& path = "/") {
    camera.emplace(
        network, parse_camera_address(fmt::format("http://127.0.0.1:{}{}", port, path)).value(), "eye_L",
        std::make_unique<headset::MjpegStream>(kCamera),
        [this](std::span<const std::byte> datagram, std::span<const std::byte> payload) {
          packets.push_back(headset::parse_picture_packet(datagram).value());
          pictures.emplace_back(payload.begin(), payload.end());
        },
        [this] {
          return HostTime(std::chrono::steady_clock::now().time_since_epoch() * (stands ? 0 : 1) + leapt);
        });
  }
  bool until(const std::function<bool()>& done) { return run_until(network, done); }
  void TearDown() override {
    if (camera) camera->close();
    if (server) server->vanish();
    network.restart();
    network.poll();
  }

  static std::string head(std::string_view more = "") {
    return fmt::format("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=b\r\n{}\r\n",
                       more);
  }
  std::string part(int number, bool with_length = true) const {
    std::string text = "\r\n--b\r\nContent-Type: image/jpeg\r\n";
    if (with_length) text += fmt::format("Content-Length: {}\r\n", jpeg.size());
    return text + fmt::format("X-Timestamp: {}.500000\r\n\r\n", number) + std::string(as_text(jpeg));
  }

  const Bytes jpeg = headset::test::grey_jpeg(40, 40, 1);
  boost::asio::io_context network;
  std::optional<CameraServer> server;
  std::optional<CameraStream> camera;
  std::vector<headset::PicturePacket> packets;
  std::vector<Bytes> pictures;
  Duration leapt{};     // What the camera's clock is ahead of the machine's.
  bool stands = false;  // It does not run by itself.
};

TEST_F(CameraStreamTest, GivesPicturesWithTheirTimes) {
  start_server([&](Visitor& visitor) {
    visitor.send(head());
    for (int i = 0; i < 5; ++i) visitor.send(part(i));
  });
  start_camera(server->port(), "/stream?fps=60");
  ASSERT_TRUE(until([&] { return pictures.size() == 5; }));
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(pictures[i], jpeg);
    EXPECT_EQ(packets[i],
              (headset::PicturePacket{.from = kCamera,
                                      .sequence = i,
                                      .time = DeviceTime(std::chrono::milliseconds(1000 * i + 500)),
                                      .first = i == 0}));
  }
  const std::string& request = server->visitors.front().request;
  EXPECT_THAT(request, StartsWith("GET /stream?fps=60 HTTP/1.1\r\n"));
  EXPECT_THAT(request, HasSubstr(fmt::format("\r\nHost: 127.0.0.1:{}\r\n", server->port())));
  const CameraStatus status = camera->status();
  EXPECT_TRUE(status.open);
  EXPECT_EQ(status.problem, "");
  EXPECT_EQ(status.address, fmt::format("http://127.0.0.1:{}/stream?fps=60", server->port()));
  EXPECT_EQ(status.pictures, sensor::StreamCounts{.whole = 5});
  EXPECT_GT(status.bytes, 5 * jpeg.size());
  EXPECT_EQ(status.lost + status.too_fast + status.held_back, 0u);
}

TEST_F(CameraStreamTest, NeedsNoLengthsAndReadsChunks) {
  start_server([&](Visitor& visitor) {
    visitor.send(head("Transfer-Encoding: chunked\r\n"));
    for (int i = 0; i < 3; ++i) {
      const std::string text = part(i, false);
      visitor.send(fmt::format("{:x}\r\n", text.size()) + text + "\r\n");
    }
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return pictures.size() == 3; }));
  EXPECT_EQ(pictures.back(), jpeg);
}

TEST_F(CameraStreamTest, HandsItsPicturesToASource) {
  start_server([&](Visitor& visitor) { visitor.send(head() + part(7)); });
  Signal awake;
  PayloadSource source(
      3, [] { return HostTime(std::chrono::seconds(1)); }, awake);
  camera.emplace(
      network, parse_camera_address(fmt::format("http://127.0.0.1:{}", server->port())).value(), "eye_L",
      std::make_unique<headset::MjpegStream>(kCamera),
      [&](auto datagram, auto payload) { source.hand_over(datagram, payload); }, [] { return HostTime(); });
  ASSERT_TRUE(until([&] { return source.counts().received == 1; }));
  const auto waiting = source.front();
  ASSERT_TRUE(waiting);
  EXPECT_TRUE(headset::is_picture_packet(waiting->datagram));
  EXPECT_TRUE(std::ranges::equal(waiting->payload, jpeg));
}

TEST_F(CameraStreamTest, AllocatesNothingWhilePicturesCome) {
  boost::asio::io_context server_network;
  CameraServer::tcp::acceptor acceptor(server_network, {boost::asio::ip::address_v4::loopback(), 0});
  std::atomic<bool> go = false;
  const std::string begin = head();
  const std::string one = part(1);
  std::jthread serving([&] {
    auto socket = acceptor.accept();
    std::array<char, 1000> request{};
    static_cast<void>(socket.read_some(boost::asio::buffer(request)));
    boost::asio::write(socket, boost::asio::buffer(begin));
    for (int i = 0; i < 20; ++i) boost::asio::write(socket, boost::asio::buffer(one));
    go.wait(false);
    for (int i = 0; i < 200; ++i) boost::asio::write(socket, boost::asio::buffer(one));
  });
  int taken = 0;
  HostTime now;
  camera.emplace(
      network,
      parse_camera_address(fmt::format("http://127.0.0.1:{}", acceptor.local_endpoint().port())).value(),
      "eye_L", std::make_unique<headset::MjpegStream>(kCamera), [&](auto, auto) { ++taken; },
      [&] { return now += std::chrono::milliseconds(10); });
  EXPECT_TRUE(run_until(network, [&] { return taken == 20; }));
  const std::size_t before = mien::test::allocation_count();
  go = true;
  go.notify_one();
  EXPECT_TRUE(run_until(network, [&] { return taken == 220; }));
  EXPECT_EQ(mien::test::allocation_count(), before);
}

TEST_F(CameraStreamTest, RefusesWhatIsNoStreamAndAsksAgain) {
  std::string answer;
  int asked = 0;
  start_server([&](Visitor& visitor) {
    ++asked;
    visitor.send(answer);
  });
  for (const auto& [sent, words] : std::vector<std::pair<std::string, std::string>>{
           {"HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Basic\r\n\r\n", "password"},
           {"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\n\r\n<html>", "text/html"},
           {head("Transfer-Encoding: chunked\r\n") + "oops\r\n", "chunk"},
           {"SSH-2.0-OpenSSH\r\n\r\n", "no answer of a camera"}}) {
    answer = sent;
    asked = 0;
    start_camera(server->port());
    ASSERT_TRUE(until([&] { return asked == 3; })) << sent;
    EXPECT_THAT(camera->status().problem, HasSubstr(words));
    EXPECT_FALSE(camera->status().open);
    EXPECT_EQ(camera->status().lost, 0u) << "it never was there";
    camera->close();
    network.restart();
    network.poll();
  }
  EXPECT_TRUE(pictures.empty());
}

TEST_F(CameraStreamTest, FollowsNoRedirect) {
  bool followed = false;
  CameraServer other(network, 0, [&](Visitor&) { followed = true; });
  int asked = 0;
  start_server([&](Visitor& visitor) {
    ++asked;
    visitor.send(fmt::format("HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1:{}/\r\n\r\n", other.port()));
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return asked == 3; }));
  EXPECT_THAT(camera->status().problem, HasSubstr("redirects are not followed"));
  EXPECT_FALSE(followed);
  EXPECT_EQ(other.visitors.size(), 1u) << "none but the one that it waits for";
  camera->close();
  other.vanish();
  network.poll();
}

TEST_F(CameraStreamTest, CutsOffAPictureThatTrickles) {
  int asked = 0;
  start_server([&](Visitor& visitor) {
    if (++asked == 1)
      visitor.send(head() + part(1) + part(2).substr(0, 300));
    else
      visitor.send(head() + part(3));
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return pictures.size() == 1 && camera->status().open; }));
  for (int i = 0; i < 3; ++i) {  // 1.5 s, and a byte each half of a second: not yet too long.
    leapt += std::chrono::milliseconds(500);
    const std::uint64_t before = camera->status().bytes;
    server->visitors.front().send("\x01");
    ASSERT_TRUE(until([&] { return camera->status().bytes > before; }));
  }
  EXPECT_TRUE(camera->status().open);
  leapt += std::chrono::milliseconds(600);
  ASSERT_TRUE(until([&] { return !camera->status().open; }));
  EXPECT_THAT(camera->status().problem, HasSubstr("two seconds"));
  EXPECT_EQ(camera->status().lost, 1u);
  ASSERT_TRUE(until([&] { return pictures.size() == 2; }));
  EXPECT_EQ(packets[1].time, DeviceTime(std::chrono::milliseconds(3500)));
  EXPECT_TRUE(packets[1].first);
  EXPECT_EQ(packets[1].sequence, 2u) << "the one that was cut off has its number";
}

TEST_F(CameraStreamTest, ASilentServerIsLeft) {
  int asked = 0;
  start_server([&](Visitor&) { ++asked; });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return asked == 1; }));
  leapt += std::chrono::seconds(3);
  ASSERT_TRUE(until([&] { return asked == 2; }));
  EXPECT_THAT(camera->status().problem, HasSubstr("another program has its stream"));
}

TEST_F(CameraStreamTest, ComesBackWhenTheServerDoes) {
  const auto answer = [&](Visitor& visitor) { visitor.send(head() + part(1)); };
  start_server(answer);
  const std::uint16_t port = server->port();
  start_camera(port);
  ASSERT_TRUE(until([&] { return pictures.size() == 1; }));
  for (std::uint64_t times = 1; times <= 2; ++times) {
    server->vanish();
    ASSERT_TRUE(until([&] { return !camera->status().open; }));
    EXPECT_EQ(camera->status().lost, times);
    EXPECT_THAT(camera->status().problem, HasSubstr("hung up"));
    ASSERT_TRUE(until([&] { return camera->status().problem.starts_with("not there"); }));
    network.poll();
    start_server(answer, port);
    ASSERT_TRUE(until([&] { return pictures.size() == times + 1; }));
    EXPECT_TRUE(camera->status().open);
    EXPECT_EQ(camera->status().problem, "");
    EXPECT_EQ(packets.back().sequence, times);
    EXPECT_TRUE(packets.back().first);
  }
}

TEST_F(CameraStreamTest, HandsOnNoMorePicturesThanACamerasRate) {
  stands = true;
  start_server([&](Visitor& visitor) {
    visitor.send(head());
    for (int i = 0; i < 400; ++i) visitor.send(part(i));
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return camera->status().pictures.whole == 400; }));
  EXPECT_EQ(pictures.size(), 130u);
  EXPECT_EQ(camera->status().too_fast, 270u);
  leapt += std::chrono::milliseconds(100);
  server->visitors.front().send(part(1) + part(2));
  ASSERT_TRUE(until([&] { return pictures.size() == 132; }));
  EXPECT_EQ(packets.back().sequence, 401u);
}

TEST_F(CameraStreamTest, ReadsNoMoreBytesThanACamerasRate) {
  stands = true;
  start_server([&](Visitor& visitor) {
    visitor.send(head() + part(1));
    for (int i = 0; i < 10; ++i) visitor.send(std::string(1'000'000, 'x'));
    visitor.send(part(2));
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return camera->status().held_back > 3; }));
  EXPECT_LT(camera->status().bytes, 8'000'000U + 16'385);
  EXPECT_GT(camera->status().bytes, 7'900'000U);
  EXPECT_EQ(pictures.size(), 1u);
  leapt += std::chrono::seconds(1);
  ASSERT_TRUE(until([&] { return pictures.size() == 2; })) << "it goes on";
  EXPECT_EQ(camera->status().lost, 0u);
}

TEST_F(CameraStreamTest, SaysThatPicturesAreTooLong) {
  start_server([&](Visitor& visitor) {
    visitor.send(head() + std::string(as_text(headset::test::overlong_jpeg(jpeg))));
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return camera->status().pictures.overlong == 1; }));
  leapt += std::chrono::seconds(3);
  ASSERT_TRUE(until([&] { return !camera->status().problem.empty(); }));
  EXPECT_THAT(camera->status().problem, HasSubstr("256 KiB"));
}

TEST_F(CameraStreamTest, CountsWhatItRefusesByItsReasonAndSaysIt) {
  stands = true;
  Bytes progressive = jpeg;
  progressive.at(headset::test::place_of(jpeg, 0xC0) + 1) = std::byte{0xC2};
  start_server([&](Visitor& visitor) {
    visitor.send(head() + part(1));
    for (int i = 0; i < 3; ++i) visitor.send(std::string(as_text(progressive)));
    visitor.send("\xFF\xD8\xFF\xD9");
  });
  start_camera(server->port());
  ASSERT_TRUE(until([&] { return camera->status().pictures.all() == 5; }));
  const CameraStatus status = camera->status();
  EXPECT_EQ(status.pictures, (sensor::StreamCounts{.whole = 1, .broken = 1, .refused = 3}));
  EXPECT_EQ(status.refusals, (std::vector<sensor::Refusal>{{.why = "progressive", .count = 3}}));
  EXPECT_EQ(status.sensor, "eye_L");
  EXPECT_EQ(pictures.size(), 1u);
  leapt += std::chrono::seconds(3);
  ASSERT_TRUE(until([&] { return !camera->status().problem.empty(); }));
  EXPECT_THAT(camera->status().problem, HasSubstr("refused (progressive)"));
}

TEST_F(CameraStreamTest, OneThatGivesAPictureAndHangsUpIsAskedEverMoreRarely) {
  stands = true;
  std::vector<std::chrono::steady_clock::time_point> asked;
  Visitor* answered = nullptr;
  start_server([&](Visitor& visitor) {
    asked.push_back(std::chrono::steady_clock::now());
    answered = &visitor;
    visitor.send(head() + part(static_cast<int>(asked.size())));
  });
  start_camera(server->port());
  // It hangs up once its picture was received.
  ASSERT_TRUE(until([&] {
    if (answered != nullptr && pictures.size() == asked.size()) {
      answered->hang_up();
      answered = nullptr;
    }
    return asked.size() == 4;
  })) << asked.size()
      << " asked, " << pictures.size() << " pictures; " << camera->status().problem;
  // After 0.1, 0.2 and 0.4 s, where it was a tenth each time before.
  EXPECT_GE(asked[3] - asked[0], std::chrono::milliseconds(690));
  EXPECT_EQ(camera->status().lost, 3u);
}

TEST_F(CameraStreamTest, WaitsForNoNameServerThatIsDead) {
  std::atomic<bool> over = false;
  std::atomic<int> answered = 0;
  {
    CameraStream named(
        network, parse_camera_address("http://headset.example/").value(), "eye_L",
        std::make_unique<headset::MjpegStream>(kCamera), [](auto, auto) {},
        [this] { return HostTime(std::chrono::steady_clock::now().time_since_epoch()) + leapt; },
        [&over, &answered](const std::string&, std::uint16_t) {
          over.wait(false);
          ++answered;
          return NameLookup::Answer{};
        });
    leapt += std::chrono::seconds(3);
    ASSERT_TRUE(until([&] { return !named.status().problem.empty(); }));
    EXPECT_THAT(named.status().problem, HasSubstr("name server"));
    named.close();
    network.restart();
    network.poll();  // What it still had to do.
  }
  EXPECT_EQ(answered, 0) << "it is gone before anybody answers";
  over = true;
  over.notify_all();
  EXPECT_TRUE(until([&] { return answered == 1; })) << "and was asked once, however often it tried";
}

TEST_F(CameraStreamTest, SaysWhyItCannotBeReached) {
  start_server([](Visitor&) {});
  const std::uint16_t port = server->port();
  server->vanish();
  start_camera(port);
  ASSERT_TRUE(until([&] { return !camera->status().problem.empty(); }));
  EXPECT_THAT(camera->status().problem, StartsWith("not there"));
}

}  // namespace
}  // namespace mien::live::camera_stream_test
