#include "mien/gaze/gaze_protocol.h"

#include <gtest/gtest.h>

#include "mien/gaze/packet.h"
#include "tests/gaze/osc_bytes.h"

namespace mien::gaze::gaze_protocol_test {
namespace {

using sensor::Verdict;
using test::bundle;
using test::message;

constexpr float kHalf = 0.46364760F;  // atan(0.5)

HostTime at(int milliseconds) {
  return HostTime(std::chrono::milliseconds(milliseconds));
}

struct Host {
  GazeProtocol protocol;
  sensor::Inbox inbox;
  Verdict hear(int ms, const std::vector<std::byte>& bytes, sensor::Peer peer = 1) {
    EXPECT_TRUE(protocol.recognises(bytes));
    inbox.clear();
    return protocol.receive(at(ms), peer, bytes, inbox);
  }
  Verdict hear(int ms, const std::string& address, const std::vector<float>& numbers, sensor::Peer peer = 1) {
    return hear(ms, message(address, numbers), peer);
  }
  /// The eyes of the sample that the last datagram brought.
  std::optional<Eyes> eyes() const {
    return inbox.readings.empty() ? std::nullopt : eyes_of(inbox.readings[0].sample);
  }
};

TEST(GazeProtocol, TakesOurPacket) {
  Packet packet{.device = 0x024D49454E60, .sequence = 5, .battery_percent = 40};
  packet.time = DeviceTime(std::chrono::seconds(2));
  packet.eyes[1] = {.yaw_rad = 0.5F, .confidence = 1};
  Host host;
  auto bytes = encode_packet(packet).value();
  ASSERT_EQ(host.hear(0, bytes), Verdict::taken);
  EXPECT_EQ(host.eyes(), packet.eyes);
  EXPECT_EQ(host.inbox.readings[0].from.device, packet.device);
  EXPECT_EQ(host.inbox.readings[0].sample.time, packet.time);
  EXPECT_FALSE(host.inbox.readings[0].sample.time_estimated);
  EXPECT_EQ(host.inbox.batteries.at(0).percent, 40);
  bytes[40] ^= std::byte{1};
  EXPECT_EQ(host.hear(0, bytes), Verdict::malformed);
}

TEST(GazeProtocol, CoordinatesOneByOneBecomeOneSampleARound) {
  Host host;
  int samples = 0;
  for (int round = 0; round < 20; ++round) {
    const int ms = 16 * round;
    host.hear(ms, "/avatar/parameters/v2/EyeLeftX", {0.5F});
    samples += static_cast<int>(host.inbox.readings.size());
    host.hear(ms, "/avatar/parameters/v2/EyeLeftY", {-0.5F});
    samples += static_cast<int>(host.inbox.readings.size());
    host.hear(ms + 1, "/avatar/parameters/v2/EyeLidLeft", {0.75F});
    samples += static_cast<int>(host.inbox.readings.size());
    host.hear(ms + 2, "/avatar/parameters/v2/EyeRightX", {0});
    samples += static_cast<int>(host.inbox.readings.size());
    ASSERT_EQ(host.hear(ms + 3, "/avatar/parameters/v2/EyeRightY", {0.5F}), Verdict::taken);
    samples += static_cast<int>(host.inbox.readings.size());
    const auto eyes = host.eyes();
    ASSERT_TRUE(eyes) << round;
    EXPECT_FLOAT_EQ((*eyes)[0].yaw_rad, -kHalf);
    EXPECT_FLOAT_EQ((*eyes)[0].pitch_rad, -kHalf);
    EXPECT_EQ((*eyes)[0].openness, 1);
    EXPECT_EQ((*eyes)[1].yaw_rad, 0);
    EXPECT_FLOAT_EQ((*eyes)[1].pitch_rad, kHalf);
    EXPECT_FALSE((*eyes)[1].openness);
    EXPECT_TRUE(host.inbox.readings[0].sample.time_estimated);
  }
  EXPECT_EQ(samples, 20);
  EXPECT_EQ(host.inbox.readings[0].from.device, kOscDevice);
}

TEST(GazeProtocol, SendersWithFewerCoordinatesHaveRoundsOfTheirOwn) {
  // EyeTrackVR's first parameters have one y for both eyes; its single eye is x and y for both.
  Host host;
  int samples = 0;
  for (int round = 0; round < 10; ++round) {
    host.hear(16 * round, "/avatar/parameters/LeftEyeX", {0.5F});
    host.hear(16 * round, "/avatar/parameters/EyesY", {0.5F});
    samples += host.eyes() ? 1 : 0;
  }
  EXPECT_GE(samples, 8);
  const auto eyes = host.eyes();
  ASSERT_TRUE(eyes);
  EXPECT_EQ((*eyes)[0].confidence, 1);
  EXPECT_EQ((*eyes)[1].confidence, 0) << "of the right eye only y is told";
}

TEST(GazeProtocol, TheFullestDialectIsBelieved) {
  Host host;
  ASSERT_EQ(host.hear(0, "/tracking/eye/LeftRightVec", {0, 0, 1, 0, 0, 1}), Verdict::taken);
  EXPECT_TRUE(host.eyes());
  const auto other = bundle({message("/LeftEyeX", {1}), message("/LeftEyeY", {1}), message("/RightEyeX", {1}),
                             message("/RightEyeY", {1})});
  EXPECT_EQ(host.hear(5, other), Verdict::taken);
  EXPECT_FALSE(host.eyes());
  EXPECT_EQ(host.hear(5 + 600, other), Verdict::taken);
  ASSERT_TRUE(host.eyes());
  EXPECT_FLOAT_EQ((*host.eyes())[0].pitch_rad, 0.78539816F);
}

TEST(GazeProtocol, AnEyeThatIsNotSeenHasNoConfidence) {
  Host host;
  host.hear(0, "/tracking/eye/LeftRightVec", {0, 621, 1, 0.5F, 0, 1});
  ASSERT_TRUE(host.eyes());
  EXPECT_EQ((*host.eyes())[0].confidence, 0);
  EXPECT_EQ((*host.eyes())[1].confidence, 1);
}

TEST(GazeProtocol, AnEyeOfWhichOneCoordinateIsLostIsNotSeen) {
  for (const bool lost_x : {true, false}) {
    Host host;
    for (int round = 0; round < 5; ++round) {
      host.hear(16 * round, "/avatar/parameters/v2/EyeLeftX", {lost_x ? 621.0F : 0.0F});
      host.hear(16 * round, "/avatar/parameters/v2/EyeLeftY", {lost_x ? 0.0F : 621.0F});
      host.hear(16 * round, "/avatar/parameters/v2/EyeRightX", {0});
      host.hear(16 * round, "/avatar/parameters/v2/EyeRightY", {0});
      ASSERT_TRUE(host.eyes());
      EXPECT_EQ((*host.eyes())[0].confidence, 0);
      EXPECT_EQ((*host.eyes())[1].confidence, 1);
    }
    host.hear(100, "/avatar/parameters/v2/EyeLeftX", {0.5F});
    host.hear(100, "/avatar/parameters/v2/EyeLeftY", {0});
    host.hear(100, "/avatar/parameters/v2/EyeRightX", {0});
    host.hear(100, "/avatar/parameters/v2/EyeRightY", {0});
    ASSERT_TRUE(host.eyes());
    EXPECT_EQ((*host.eyes())[0].confidence, 1) << "found again";
  }
}

TEST(GazeProtocol, AProgramThatStartsAnewOnAnotherPortIsTheSameDevice) {
  Host host;
  const std::vector<float> ahead = {0, 0, 1, 0, 0, 1};
  host.hear(0, "/tracking/eye/LeftRightVec", ahead, 1);
  host.hear(0, "/tracking/eye/LeftRightVec", ahead, 2);
  host.hear(1'900, "/tracking/eye/LeftRightVec", ahead, 2);
  host.hear(2'500, "/tracking/eye/LeftRightVec", ahead, 3);
  EXPECT_EQ(host.inbox.readings.at(0).from.device, kOscDevice) << "the first one's, which is gone";
  host.hear(2'600, "/tracking/eye/LeftRightVec", ahead, 4);
  EXPECT_EQ(host.inbox.readings.at(0).from.device, kOscDevice + 2) << "nobody is gone";
}

TEST(GazeProtocol, OtherOscIsIgnoredAndDamagedOscIsMalformed) {
  Host host;
  EXPECT_EQ(host.hear(0, "/avatar/parameters/v2/JawOpen", {1}), Verdict::ignored);
  EXPECT_EQ(host.hear(0, "/LeftEyeX", {}), Verdict::malformed);
  auto cut = message("/LeftEyeX", {1});
  cut.pop_back();
  EXPECT_EQ(host.hear(0, cut), Verdict::malformed);
  EXPECT_TRUE(host.inbox.readings.empty());
  const std::string text = "512,498,1003,17\n";
  EXPECT_FALSE(host.protocol.recognises(std::as_bytes(std::span(text))));
}

TEST(GazeProtocol, ManySendersTakeNobodysPlace) {
  Host host;
  const std::vector<float> ahead = {0, 0, 1, 0, 0, 1};
  for (sensor::Peer peer = 0; peer < 40; ++peer) {
    const bool room = peer < kMostOscDevices;
    EXPECT_EQ(host.hear(0, "/tracking/eye/LeftRightVec", ahead, peer),
              room ? Verdict::taken : Verdict::ignored);
  }
  host.hear(9'000, "/tracking/eye/LeftRightVec", ahead, 3);
  ASSERT_EQ(host.hear(11'000, "/tracking/eye/LeftRightVec", ahead, 77), Verdict::taken);
  EXPECT_EQ(host.inbox.readings.at(0).from.device, kOscDevice);
  host.hear(11'000, "/tracking/eye/LeftRightVec", ahead, 3);
  EXPECT_EQ(host.inbox.readings.at(0).from.device, kOscDevice + 3);
}

}  // namespace
}  // namespace mien::gaze::gaze_protocol_test
