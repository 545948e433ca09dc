// Packets that a phone and a known tool have sent, as the session decodes them. The recordings are not part
// of this project: where they are missing the test says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

#include "mien/face/profile.h"
#include "mien/phone/live_link.h"
#include "tests/captured_packets.h"

namespace mien::phone::test::captured_packets_test {
namespace {

TEST(CapturedPackets, OfAPhoneMeanWhatTheirSenderSaid) {
  const auto path = livelink_packets() / "dao.gesichter";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no captured packets at " << path;
  LiveLinkProtocol protocol;
  sensor::Inbox inbox;
  std::optional<std::uint32_t> frame, sequence;
  for (const auto& bytes : captured_packets(path)) {
    ASSERT_TRUE(is_live_link(bytes));
    const auto packet = parse_live_link(bytes);
    ASSERT_TRUE(packet) << packet.error().message();
    ASSERT_TRUE(packet->values);
    // The last 244 bytes are the values, as other receivers read them.
    const std::span<const std::byte> whole = bytes;
    ByteReader reader(whole.last(4 * face::kLiveLinkValueCount));
    for (const float value : *packet->values) EXPECT_EQ(value, reader.big<float>());
    const ToldFace face = told_face(*packet->values);
    EXPECT_TRUE(is_sound(face));
    EXPECT_TRUE(std::ranges::equal(std::span(face.weights).first(52), std::span(*packet->values).first(52)));
    // Dropped frames are missed, and no other.
    inbox.clear();
    ASSERT_EQ(protocol.receive({}, 1, bytes, inbox), sensor::Verdict::taken);
    const std::uint32_t now = inbox.readings.at(0).sample.sequence;
    if (frame) {
      EXPECT_EQ(now - *sequence, packet->frame - *frame);
    }
    frame = packet->frame;
    sequence = now;
  }
}

TEST(CapturedPackets, EachShapeIsTheOneThatItsRecordingIsNamedAfter) {
  std::size_t seen = 0;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(livelink_packets(), code)) {
    const std::string name = entry.path().stem().string();
    if (!name.starts_with("debug-") || name == "debug-all-blendshapes" || name == "debug-headyaw") continue;
    const std::size_t shape = face::arkit_index(name.substr(6));
    ASSERT_LT(shape, 52U) << name;
    float least = 1, most = 0;
    for (const auto& bytes : captured_packets(entry.path())) {
      const ToldFace face = told_face(parse_live_link(bytes).value().values.value());
      for (std::size_t i = 0; i < 52; ++i)
        if (i != shape) {
          EXPECT_EQ(face.weights[i], 0) << name << " " << i;
        }
      least = std::min(least, face.weights[shape]);
      most = std::max(most, face.weights[shape]);
    }
    EXPECT_EQ(least, 0) << name << ": it sends down to -1";
    EXPECT_EQ(most, 1) << name;
    ++seen;
  }
  if (seen == 0) GTEST_SKIP() << "no captured packets at " << livelink_packets();
}

}  // namespace
}  // namespace mien::phone::test::captured_packets_test
