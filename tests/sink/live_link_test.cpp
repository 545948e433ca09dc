#include "mien/sink/live_link.h"

#include <gtest/gtest.h>

#include "mien/core/bytes.h"
#include "tests/hex.h"

namespace mien::sink::live_link_test {
namespace {

face::OutputFrame speaking() {
  face::OutputFrame frame;
  frame.weights[face::shape("jawOpen")] = 0.5F;
  frame.tongue_out = 1.0F;
  return frame;
}

/// A known vector: id, subject, frame 100, jawOpen 0.5, tongueOut 1.
TEST(LiveLink, IsTheKnownPacket) {
  Datagrams out;
  encode_live_link(arkit_frame(speaking()), {"00000000-0000-0000-0000-000000000001", "face"}, 100, out);
  ASSERT_EQ(out.size(), 1u);
  const auto packet = out[0];
  ASSERT_EQ(packet.size(), 310u);
  EXPECT_EQ(
      hex(packet.first(66)),
      "060000002430303030303030302d303030302d303030302d303030302d3030303030303030303030310000000466616365"
      "00000064000000000000003c000000013d");
  std::string zeros(8 * 61, '0');
  zeros.replace(8 * 17, 8, "3f000000");
  zeros.replace(8 * 51, 8, "3f800000");
  EXPECT_EQ(hex(packet.subspan(66)), zeros);
}

std::vector<float> values_of(const face::OutputFrame& frame) {
  Datagrams out;
  encode_live_link(arkit_frame(frame), live_link_source("x"), 0, out);
  ByteReader reader(out[0].last(244));
  std::vector<float> values;
  while (reader.left() > 0) values.push_back(reader.big<float>());
  return values;
}

TEST(LiveLink, TurnsAnglesIntoItsOwnSigns) {
  face::OutputFrame frame;
  // The head looks 0.2 rad to the performer's left and 0.1 rad down; the left eye left and up.
  frame.head = Quat(Eigen::AngleAxisd(0.2, Vec3::UnitY()) * Eigen::AngleAxisd(0.1, Vec3::UnitX()));
  frame.eyes_rad = {Eigen::Vector2f(0.3F, 0.4F), Eigen::Vector2f(-0.5F, -0.6F)};
  const auto values = values_of(frame);
  ASSERT_EQ(values.size(), 61u);
  EXPECT_NEAR(values[52], -0.2, 1e-6);
  EXPECT_NEAR(values[53], 0.1, 1e-6);
  EXPECT_NEAR(values[54], 0, 1e-6);
  EXPECT_FLOAT_EQ(values[55], -0.3F);
  EXPECT_FLOAT_EQ(values[56], -0.4F);
  EXPECT_EQ(values[57], 0);
  EXPECT_FLOAT_EQ(values[58], 0.5F);
  EXPECT_FLOAT_EQ(values[59], 0.6F);
  EXPECT_EQ(values[60], 0);
}

TEST(LiveLink, NeverClosesTheMouthMoreThanTheJawIsOpen) {
  face::OutputFrame frame;
  frame.weights[face::shape("jawOpen")] = 0.25F;
  frame.weights[face::shape("mouthClose")] = 0.75F;
  EXPECT_EQ(values_of(frame)[face::arkit_index("mouthClose")], 0.25F);
}

TEST(LiveLink, WithoutAFaceEndsBehindItsRate) {
  Datagrams out;
  encode_live_link({.number = 0x1'0000'0101, .rate_hz = 30}, {"id", "face"}, out);
  EXPECT_EQ(hex(out[0]),
            "06"
            "000000026964"
            "0000000466616365"
            "00000101000000000000001e00000001");
}

TEST(LiveLink, NamesADeviceByItsSubject) {
  const auto source = live_link_source("Ann");
  EXPECT_EQ(source.subject, "Ann");
  ASSERT_EQ(source.device_id.size(), 36u);
  EXPECT_EQ(source.device_id[14], '8');
  EXPECT_EQ(source.device_id, live_link_source("Ann").device_id);
  EXPECT_NE(source.device_id, live_link_source("Bob").device_id);
  EXPECT_EQ(live_link_source(std::string(900, 'x')).subject.size(), kMaxLiveLinkName);
}

}  // namespace
}  // namespace mien::sink::live_link_test
