// Packets that a phone and a known tool have sent, against our own layout. The recordings are not part of
// this project: where they are missing the test says so.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "mien/core/bytes.h"
#include "mien/face/livelink_csv.h"
#include "mien/sink/live_link.h"
#include "tests/captured_packets.h"

namespace mien::sink::captured_packets_test {
namespace {

struct Packet {
  std::size_t size = 0;
  LiveLinkSource source;
  std::int32_t frame = 0;
  float sub_frame = 0;
  std::int32_t numerator = 0;
  std::int32_t denominator = 0;
  std::vector<float> values;
};

/// By the layout of docs/reference/sinks.md, read with nothing of the encoder.
Packet decode(std::span<const std::byte> bytes) {
  Packet packet;
  packet.size = bytes.size();
  ByteReader reader(bytes);
  EXPECT_EQ(reader.big<std::uint8_t>(), 6);
  const auto text = [&reader] {
    const auto size = reader.big<std::int32_t>();
    const auto part = reader.take(static_cast<std::size_t>(size));
    return std::string(reinterpret_cast<const char*>(part.data()), part.size());
  };
  packet.source.device_id = text();
  packet.source.subject = text();
  packet.frame = reader.big<std::int32_t>();
  packet.sub_frame = reader.big<float>();
  packet.numerator = reader.big<std::int32_t>();
  packet.denominator = reader.big<std::int32_t>();
  const auto count = reader.big<std::uint8_t>();
  EXPECT_EQ(count, 61);
  for (int i = 0; i < count; ++i) packet.values.push_back(reader.big<float>());
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.left(), 0u);
  return packet;
}

/// Names of the 61 as the recordings' file names have them, in the order in which we send.
std::vector<std::string> names() {
  std::vector<std::string> all(face::arkit52().shapes.begin(), face::arkit52().shapes.end());
  for (const char* angle : {"HeadYaw", "HeadPitch", "HeadRoll", "LeftEyeYaw", "LeftEyePitch", "LeftEyeRoll",
                            "RightEyeYaw", "RightEyePitch", "RightEyeRoll"})
    all.emplace_back(angle);
  for (std::string& name : all)
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return all;
}

TEST(CapturedPackets, HaveOurLayout) {
  const auto path = livelink_packets() / "dao.gesichter";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no captured packets at " << path;
  const auto packets = captured_packets(path);
  ASSERT_EQ(packets.size(), 180u);
  for (const auto& bytes : packets) {
    const Packet captured = decode(bytes);
    EXPECT_EQ(captured.numerator, 60);
    EXPECT_EQ(captured.denominator, 1);
    // The same face as we would send it: byte for byte the same but for what is ours to choose.
    face::ArkitWeights weights;
    std::copy_n(captured.values.begin(), 52, weights.values.begin());
    float tongue_out = 0;
    face::OutputFrame frame;
    frame.weights = face::ict_from_arkit(weights, &tongue_out);
    frame.tongue_out = tongue_out;
    const auto angle = [&](std::size_t i) { return captured.values[52 + i]; };
    frame.head = face::head_from_livelink(
        Vec3(static_cast<double>(angle(0)), static_cast<double>(angle(1)), static_cast<double>(angle(2))));
    frame.eyes_rad = {Eigen::Vector2f(-angle(3), -angle(4)), Eigen::Vector2f(-angle(6), -angle(7))};
    Datagrams out;
    encode_live_link(arkit_frame(frame), captured.source, captured.frame, out);
    ASSERT_EQ(out[0].size(), bytes.size());
    const Packet ours = decode(out[0]);
    EXPECT_EQ(ours.frame, captured.frame);
    EXPECT_EQ(ours.source.subject, captured.source.subject);
    const std::size_t header = bytes.size() - 244;
    for (std::size_t i = 0; i < header; ++i) {
      if (i >= header - 13 && i < header - 9) continue;  // The sub-frame.
      EXPECT_EQ(out[0][i], bytes[i]) << i;
    }
    for (std::size_t i = 0; i < 61; ++i) {
      if (i == 57 || i == 60) continue;  // The roll of the eyes, about 0.
      const float tolerance = i >= 52 && i < 55 ? 1e-6F : 0.0F;
      // A mouth that is closed further than the jaw is open is held back, on purpose.
      const float expected =
          i == 18 ? std::min(captured.values[18], captured.values[17]) : captured.values[i];
      EXPECT_NEAR(ours.values[i], expected, tolerance) << i;
    }
  }
}

/// Each recording turns one value up and down, and is named after it.
TEST(CapturedPackets, HaveOurOrder) {
  std::size_t seen = 0;
  const auto all = names();
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(livelink_packets(), code)) {
    const std::string name = entry.path().stem().string();
    if (!name.starts_with("debug-") || name == "debug-all-blendshapes") continue;
    const auto at = std::ranges::find(all, name.substr(6));
    ASSERT_NE(at, all.end()) << name;
    float largest = 0;
    for (const auto& bytes : captured_packets(entry.path())) {
      const Packet packet = decode(bytes);
      for (std::size_t i = 0; i < packet.values.size(); ++i) {
        if (i == static_cast<std::size_t>(at - all.begin()))
          largest = std::max(largest, packet.values[i]);
        else
          EXPECT_EQ(packet.values[i], 0) << name << " " << i;
      }
    }
    EXPECT_EQ(largest, 1) << name;
    ++seen;
  }
  // One recording goes through all in the same order, one after the other.
  const auto path = livelink_packets() / "debug-all-blendshapes.gesichter";
  if (std::filesystem::exists(path)) {
    std::vector<std::size_t> order;
    for (const auto& bytes : captured_packets(path)) {
      const Packet packet = decode(bytes);
      for (std::size_t i = 0; i < packet.values.size(); ++i)
        if (packet.values[i] != 0 && (order.empty() || order.back() != i)) order.push_back(i);
    }
    std::vector<std::size_t> expected(order.size());
    std::ranges::generate(expected, [i = std::size_t{0}]() mutable { return i++; });
    EXPECT_GE(order.size(), 60u);
    EXPECT_EQ(order, expected);
  }
  if (seen == 0) GTEST_SKIP() << "no captured packets at " << livelink_packets();
}

}  // namespace
}  // namespace mien::sink::captured_packets_test
