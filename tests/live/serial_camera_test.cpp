#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/serial_port.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_streams.h"
#include "mien/live/intake.h"
#include "tests/folder.h"
#include "tests/headset/small_jpeg.h"
#include "tests/live/pseudo_terminal.h"
#include "tests/network.h"

// Camera boards on a serial line: what mien/headset/etvr_frames.h reads, over a pseudo-terminal.
namespace mien::live::serial_camera_test {
namespace {

using headset::test::Bytes;
using headset::test::operator+=;
using mien::test::run_until;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr sensor::DeviceKey kEye{.device = 0x024D49484401};

Bytes etvr(const Bytes& jpeg, std::size_t length) {
  Bytes out = {std::byte{0xFF},
               std::byte{0xA0},
               std::byte{0xFF},
               std::byte{0xA1},
               static_cast<std::byte>(length),
               static_cast<std::byte>(length >> 8U)};
  out += jpeg;
  return out;
}

class SerialCamera : public ::testing::Test {
 protected:
  void open() {
    auto opened = SerialPort::open(
        network, parse_serial_address(cable.address() + "?baud=3000000").value(),
        [this](auto frame) { frames.emplace_back(as_text(frame)); },
        LineCamera{.sensor = "eye_L", .stream = std::make_unique<headset::EtvrStream>(kEye)},
        [this](auto datagram, auto payload) {
          packets.push_back(headset::parse_picture_packet(datagram).value());
          pictures.emplace_back(payload.begin(), payload.end());
        },
        [this] { return HostTime(leapt); });
    ASSERT_TRUE(opened) << opened.error().message();
    port = std::move(*opened);
  }
  /// The board says it, and it comes in.
  void say(std::span<const std::byte> left) {
    const std::uint64_t until = port->status().bytes + left.size();
    EXPECT_TRUE(run_until(network, [&] {
      left = left.subspan(cable.write(left));
      return port->status().bytes >= until;
    }));
  }
  void show(int number) {
    const Bytes jpeg = headset::test::grey_jpeg(40, 40, number);
    say(etvr(jpeg, jpeg.size()));
  }

  mien::test::Folder folder;
  test::Cable cable{folder / "eye"};
  boost::asio::io_context network;
  std::vector<std::string> frames;
  std::vector<headset::PicturePacket> packets;
  std::vector<Bytes> pictures;
  Duration leapt{};  // What the line's clock says: it does not run by itself.
  std::unique_ptr<SerialPort> port;
};

TEST_F(SerialCamera, GivesItsPicturesAndNoFramesOfThem) {
  open();
  EXPECT_FALSE(port->status().camera) << "nobody knows yet what it is";
  for (int i = 0; i < 5; ++i) show(i);
  ASSERT_EQ(pictures.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(pictures[static_cast<std::size_t>(i)], headset::test::grey_jpeg(40, 40, i));
    EXPECT_EQ(
        packets[static_cast<std::size_t>(i)],
        (headset::PicturePacket{
            .from = kEye, .sequence = static_cast<std::uint32_t>(i), .time = std::nullopt, .first = i == 0}));
  }
  const auto camera = port->status().camera;
  ASSERT_TRUE(camera);
  EXPECT_TRUE(camera->open);
  EXPECT_EQ(camera->address, cable.address());
  EXPECT_EQ(camera->sensor, "eye_L");
  EXPECT_EQ(camera->pictures, sensor::StreamCounts{.whole = 5});
  frames.clear();
  say(headset::test::text_bytes("1,2,3\n"));
  EXPECT_THAT(frames, IsEmpty()) << "what a camera's line holds beside pictures is no device's";
}

TEST_F(SerialCamera, ALineOfAnotherDeviceIsReadAsEver) {
  open();
  say(headset::test::text_bytes("1,2,3\n4,5,6\n"));
  EXPECT_THAT(frames, ElementsAre("1,2,3", "4,5,6"));
  EXPECT_FALSE(port->status().camera);
  leapt += std::chrono::seconds(5);
  say(headset::test::text_bytes("7,8,9\n"));
  EXPECT_EQ(port->status().problem, "") << "it owes nobody pictures";
}

TEST_F(SerialCamera, ALengthThatLiesCostsItsPictureAlone) {
  open();
  const Bytes jpeg = headset::test::grey_jpeg(40, 40, 3);
  const std::array<std::size_t, 5> lies = {0, 2, jpeg.size() - 1, jpeg.size() + 1, 0xFFFF};
  for (const std::size_t length : lies) {
    say(etvr(jpeg, length));
    show(4);
  }
  EXPECT_EQ(pictures.size(), lies.size());
  EXPECT_EQ(port->status().camera->pictures,
            (sensor::StreamCounts{.whole = lies.size(), .broken = lies.size()}));
  say(etvr(headset::test::text_bytes("\xFF\xD8\xFF\xD9"), 4));
  show(5);
  EXPECT_EQ(port->status().camera->pictures.broken, lies.size() + 1) << "no picture is in it";
}

TEST_F(SerialCamera, ThatVanishesInAPictureIsBackWhenItIsPluggedIn) {
  open();
  show(1);
  for (std::uint64_t times = 1; times <= 2; ++times) {
    const Bytes jpeg = headset::test::grey_jpeg(40, 40, 2);
    const Bytes frame = etvr(jpeg, jpeg.size());
    say(std::span(frame).first(frame.size() / 2));
    cable.unplug();
    ASSERT_TRUE(run_until(network, [&] { return !port->status().open; }));
    const CameraStatus gone = port->status().camera.value();
    EXPECT_FALSE(gone.open);
    EXPECT_THAT(gone.problem, HasSubstr("unplugged"));
    EXPECT_EQ(gone.lost, times);
    cable.plug();
    ASSERT_TRUE(run_until(network, [&] { return port->status().open; }));
    say(std::span(frame).last(frame.size() / 2));
    show(3);
    EXPECT_EQ(pictures.back(), headset::test::grey_jpeg(40, 40, 3));
    EXPECT_TRUE(packets.back().first) << "of this connection";
    EXPECT_EQ(packets.back().sequence, 2 * times) << "the one that was cut has its number";
    EXPECT_TRUE(port->status().camera->open);
    EXPECT_EQ(port->status().camera->problem, "");
  }
}

TEST_F(SerialCamera, ThatStallsIsSaidAndGoesOn) {
  open();
  show(1);
  leapt += std::chrono::milliseconds(1900);
  say(headset::test::text_bytes("no picture"));
  EXPECT_TRUE(port->status().camera->open);
  leapt += std::chrono::milliseconds(200);
  ASSERT_TRUE(run_until(network, [&] { return !port->status().camera->open; }));
  EXPECT_THAT(port->status().camera->problem, HasSubstr("stalled: no whole picture for two seconds"));
  EXPECT_EQ(port->status().camera->lost, 1u);
  EXPECT_TRUE(port->status().open) << "to open it anew would begin the board anew";
  EXPECT_EQ(port->status().unplugged, 0u);
  show(2);
  EXPECT_TRUE(port->status().camera->open);
  EXPECT_EQ(packets.back().sequence, 1u);
}

TEST_F(SerialCamera, GivesNoMoreThanACamera) {
  open();
  for (int i = 0; i < 200; ++i) show(1);
  EXPECT_EQ(pictures.size(), 130u);
  EXPECT_EQ(port->status().camera->too_fast, 70u);
  const Bytes flood(1'000'000, std::byte{'x'});
  const std::uint64_t before = port->status().bytes;
  std::uint64_t written = 0;
  ASSERT_TRUE(run_until(network, [&] {
    written += cable.write(flood);
    return port->status().camera->held_back > 3;
  }));
  EXPECT_LT(port->status().bytes, 8'000'000U + 4097) << "and so it is the board that waits";
  leapt += std::chrono::seconds(1);
  ASSERT_TRUE(run_until(network, [&] { return port->status().bytes >= before + written; }));
  show(2);
  EXPECT_EQ(pictures.size(), 131u);
}

TEST_F(SerialCamera, ItsPicturesComeFromItsLine) {
  Intake intake(network, [] { return HostTime(std::chrono::seconds(7)); });
  const auto listening =
      intake.listen(cable.address() + "?baud=3000000",
                    LineCamera{.sensor = "eye_L", .stream = std::make_unique<headset::EtvrStream>(kEye)});
  ASSERT_TRUE(listening) << listening.error().message();
  EXPECT_EQ(*listening, cable.address() + "?baud=3000000");
  const Bytes jpeg = headset::test::grey_jpeg(40, 40, 1);
  const Bytes words = headset::test::text_bytes("1,2\n");
  ASSERT_EQ(cable.write(words), words.size());
  ASSERT_TRUE(run_until(network, [&] { return intake.counts().received == 1; }));
  const auto frame = intake.front();
  ASSERT_TRUE(frame);
  EXPECT_EQ(as_text(frame->bytes), "1,2");
  const sensor::Peer line = frame->peer;
  intake.release();
  const Bytes all = etvr(jpeg, jpeg.size());
  std::span<const std::byte> rest = all;
  ASSERT_TRUE(run_until(network, [&] {
    rest = rest.subspan(cable.write(rest));
    return intake.lines().front().camera.has_value();
  }));
  // What of the picture's first bytes looked like frames came before it.
  std::optional<Arrived> picture = intake.front();
  while (picture && picture->payload.empty()) {
    intake.release();
    picture = intake.front();
  }
  ASSERT_TRUE(picture);
  EXPECT_TRUE(headset::is_picture_packet(picture->bytes));
  EXPECT_TRUE(std::ranges::equal(picture->payload, jpeg));
  EXPECT_EQ(picture->source, cable.address());
  EXPECT_EQ(picture->peer, line);
  EXPECT_EQ(picture->arrival, HostTime(std::chrono::seconds(7)));
  intake.release();
  intake.close();
}

}  // namespace
}  // namespace mien::live::serial_camera_test
