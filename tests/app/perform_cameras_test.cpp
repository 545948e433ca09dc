// `mien perform --to http://`: a virtual headset's cameras, as whoever asks them sees them.
#include <utility>  // Before Asio 1.74, which forgets it.

#include <gmock/gmock.h>
#include <signal.h>

#include <boost/asio.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "mien/core/files.h"
#include "mien/headset/picture_decoder.h"
#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_streams.h"
#include "mien/live/camera_stream.h"
#include "mien/live/picture_server.h"
#include "tests/app/program.h"
#include "tests/network.h"
#include "tests/project_path.h"

namespace mien::app::test::perform_cameras_test {
namespace {

using mien::test::run_until;
using ::testing::HasSubstr;

/// A shipped rig, its cameras with small and few pictures, of which none is lost.
std::string small_rig(const std::string& name = "headset.toml") {
  std::string rig = read_text(project_path("rigs/" + name)).value();
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"size = [240, 240]", "size = [64, 48]"},
                                 {"rate_hz = 60.0", "rate_hz = 20.0"},
                                 {"lost = 0.002", "lost = 0"}})
    for (std::size_t at = rig.find(from); at != std::string::npos; at = rig.find(from, at + to.size()))
      rig.replace(at, from.size(), to);
  return rig;
}

/// The first of four ports in a row of which nobody has one.
std::uint16_t four_ports(boost::asio::io_context& network) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    std::vector<std::unique_ptr<live::PictureServer>> all;
    auto first = live::PictureServer::open(network, {});
    if (!first || (*first)->port() > 65'000) continue;
    const std::uint16_t port = (*first)->port();
    all.push_back(*std::move(first));
    for (std::uint16_t c = 1; c < 4; ++c)
      if (auto next = live::PictureServer::open(network, {.port = static_cast<std::uint16_t>(port + c)}))
        all.push_back(*std::move(next));
    if (all.size() == 4) return port;
  }
  return 0;
}

class PerformCameras : public ::testing::Test {
 protected:
  struct Camera {
    std::unique_ptr<live::CameraStream> stream;
    std::vector<headset::PicturePacket> packets;
    std::vector<std::vector<std::byte>> pictures;
  };
  void SetUp() override {
    write(rig, small_rig());
    port = four_ports(network);
    ASSERT_NE(port, 0);
    address = "http://127.0.0.1:" + std::to_string(port);
  }
  void ask(std::size_t camera) {
    Camera& one = cameras[camera];
    one.stream = std::make_unique<live::CameraStream>(
        network, live::parse_camera_address("http://127.0.0.1:" + std::to_string(port + camera)).value(),
        "camera", std::make_unique<headset::MjpegStream>(sensor::DeviceKey{.device = camera}),
        [&one](std::span<const std::byte> datagram, std::span<const std::byte> payload) {
          one.packets.push_back(headset::parse_picture_packet(datagram).value());
          one.pictures.emplace_back(payload.begin(), payload.end());
        },
        [] { return HostTime(std::chrono::steady_clock::now().time_since_epoch()); });
  }
  std::vector<std::string> arguments(std::vector<std::string> more) const {
    std::vector<std::string> all = {"perform", "--rig", rig, "--to", address, "--json", "--voice", "babble"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// Ends of itself, or after `enough`.
  nlohmann::json watched(const std::vector<std::string>& more, const std::function<bool()>& enough) {
    const pid_t process = start(arguments(more), folder / "out", folder / "err");
    for (std::size_t c = 0; c < 4; ++c) ask(c);
    int status = 0;
    bool over = false, told = false;
    EXPECT_TRUE(run_until(network, [&] {
      if (!told && enough()) {
        told = true;
        ::kill(process, SIGINT);
      }
      over = over || ::waitpid(process, &status, WNOHANG) == process;
      return over;
    }));
    if (!over) {
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
    }
    for (Camera& one : cameras) one.stream->close();
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << content(folder / "err");
    return nlohmann::json::parse(content(folder / "out"), nullptr, false);
  }

  Folder folder;
  const std::string rig = folder / "rig.toml";
  boost::asio::io_context network;
  std::uint16_t port = 0;
  std::string address;
  std::array<Camera, 4> cameras;
};

TEST_F(PerformCameras, RendersAheadAndStreamsAtTheRigsSizeAndRate) {
  const auto summary =
      watched({"--seconds", "1", "--prologue", "none", "--ahead", "--wait", "60"}, [] { return false; });
  ASSERT_TRUE(summary.is_object()) << content(folder / "out");
  EXPECT_EQ(summary.at("cameras"), 4);
  EXPECT_EQ(summary.at("watched"), 4);
  EXPECT_EQ(summary.at("skipped"), 0);
  EXPECT_EQ(summary.at("stopped"), false);
  headset::PictureDecoder decoder = headset::PictureDecoder::create().value();
  for (const Camera& one : cameras) {
    // A second of performance, and what was sent while it waited.
    ASSERT_GE(one.pictures.size(), 20U);
    for (std::size_t i = 0; i < one.pictures.size(); ++i) {
      const auto picture = decoder.decode(one.pictures[i], 64, 48);
      ASSERT_TRUE(picture);
      EXPECT_EQ(picture->width, 64);
      EXPECT_EQ(picture->height, 48);
      ASSERT_TRUE(one.packets[i].time);
      if (one.packets[i].first) continue;
      EXPECT_NEAR(to_seconds(*one.packets[i].time - *one.packets[i - 1].time), 0.05, 0.004)
          << "the pace goes on, where the wait comes again too";
    }
    EXPECT_NE(one.pictures.front(), one.pictures.back());
  }
}

TEST_F(PerformCameras, LoopsUntilItIsStopped) {
  const auto summary =
      watched({"--seconds", "1", "--prologue", "none", "--ahead", "--loop", "--wait", "60"},
              [&] { return cameras[0].pictures.size() > 80 && cameras[3].pictures.size() > 80; });
  ASSERT_TRUE(summary.is_object());
  EXPECT_EQ(summary.at("stopped"), true);
  EXPECT_GE(summary.at("rounds"), 2);
  const Camera& one = cameras[0];
  for (std::size_t i = 1; i < one.packets.size(); ++i) {
    if (one.packets[i].first) continue;
    EXPECT_NEAR(to_seconds(*one.packets[i].time - *one.packets[i - 1].time), 0.05, 0.004);
  }
}

TEST_F(PerformCameras, RendersWhileItPerforms) {
  const auto summary =
      watched({"--seconds", "1", "--prologue", "none", "--wait", "60"}, [] { return false; });
  ASSERT_TRUE(summary.is_object());
  EXPECT_EQ(summary.at("watched"), 4);
  EXPECT_GT(summary.at("pictures"), 0);
  headset::PictureDecoder decoder = headset::PictureDecoder::create().value();
  ASSERT_FALSE(cameras[2].pictures.empty());
  const auto picture = decoder.decode(cameras[2].pictures.back(), 96, 72);
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width, 96) << "small, but in the rig's proportion";
  EXPECT_EQ(picture->height, 72);
}

TEST_F(PerformCameras, BoardsSendMeanwhile) {
  write(rig, small_rig("imu_headset.toml"));
  boost::asio::ip::udp::socket receiver(network, {boost::asio::ip::address_v4::loopback(), 0});
  const std::string boards = "udp://127.0.0.1:" + std::to_string(receiver.local_endpoint().port());
  const auto performed = [&](std::vector<std::string> more) {
    std::vector<std::string> all = {"perform", "--rig", rig, "--voice", "babble", "--seconds", "1"};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  };
  const Outcome outcome = performed(
      {"--prologue", "none", "--to", boards, "--cameras", address, "--ahead", "--wait", "0.3", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_GE(summary.at("packets"), 100);
  EXPECT_GE(summary.at("nodes"), 5);
  EXPECT_EQ(summary.at("stopped"), false);
  EXPECT_EQ(summary.at("cameras").at("cameras"), 4);
  EXPECT_GE(summary.at("cameras").at("pictures"), 4 * 20);
  // One performance, as long for both.
  EXPECT_NEAR(summary.at("duration_s").get<double>(), summary.at("cameras").at("duration_s").get<double>(),
              0.6);
  EXPECT_GT(receiver.available(), 0U);

  EXPECT_THAT(performed({"--to", boards}).err, HasSubstr("--cameras http://HOST:PORT"));
  EXPECT_THAT(performed({"--to", address}).err, HasSubstr("--to udp://HOST:PORT --cameras"));
  EXPECT_THAT(performed({"--to", address, "--cameras", address}).err, HasSubstr("an address of their own"));
  EXPECT_THAT(performed({"--to", boards, "--cameras", boards}).err, HasSubstr("an address of their own"));
  // Where one of the two cannot be, the other does not go on alone.
  EXPECT_THAT(
      performed({"--to", "udp://no.such.host.invalid:5005", "--cameras", address, "--wait", "60"}).err,
      HasSubstr("no.such.host.invalid"));
  const auto taken = live::PictureServer::open(network, {.port = port});
  ASSERT_TRUE(taken);
  EXPECT_THAT(performed({"--to", boards, "--cameras", address}).err, HasSubstr("no camera can be there"));
}

TEST_F(PerformCameras, RefusesWhatCannotBe) {
  const auto refused = [&](std::vector<std::string> more) {
    const Outcome outcome = run(more);
    EXPECT_NE(outcome.status, 0) << joined(more);
    return outcome.err;
  };
  const std::string imus = project_path("rigs/default.toml");
  const std::vector<std::string> base = {"perform", "--rig", rig, "--seconds", "1"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> all = base;
    all.insert(all.end(), more.begin(), more.end());
    return refused(all);
  };
  for (const char* to :
       {"http://", "http://127.0.0.1", "http://127.0.0.1:0", "http://127.0.0.1:x", "http://:81"})
    EXPECT_THAT(with({"--to", to}), HasSubstr("http://HOST:PORT")) << to;
  EXPECT_THAT(with({"--to", "http://127.0.0.1:65534"}), HasSubstr("lower port"));
  EXPECT_THAT(with({"--to", "udp://127.0.0.1:5005"}), HasSubstr("--to http://HOST:PORT"));
  EXPECT_THAT(with({"--to", "udp://127.0.0.1:5005", "--ahead"}), HasSubstr("--ahead"));
  with({"--take", folder / "a.mien", "--ahead"});
  EXPECT_THAT(with({"--to", address, "--headset-failure", "foot"}), HasSubstr("no such failure"));
  EXPECT_THAT(with({"--to", address, "--headset-failure", "hand@5-2"}), HasSubstr("hand@4-9"));
  EXPECT_THAT(refused({"perform", "--rig", imus, "--seconds", "1", "--to", address}),
              HasSubstr("the rig is of other sensors"));
  EXPECT_THAT(refused({"perform", "--rig", imus, "--seconds", "1", "--take", folder / "a.mien",
                       "--headset-failure", "hand"}),
              HasSubstr("no cameras"));
  EXPECT_THAT(refused({"perform", "--rig", rig, "--seconds", "90", "--ahead", "--to", address}),
              HasSubstr("too long to be rendered ahead"));
  const auto taken = live::PictureServer::open(network, {.port = static_cast<std::uint16_t>(port + 2)});
  ASSERT_TRUE(taken);
  EXPECT_THAT(with({"--to", address}), HasSubstr(std::to_string(port + 2) + ": no camera can be there"));
}

}  // namespace
}  // namespace mien::app::test::perform_cameras_test
