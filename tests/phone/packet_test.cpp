#include "mien/phone/packet.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"
#include "tests/hex.h"
#include "tests/wrong_packets.h"

namespace mien::phone::packet_test {
namespace {

/// ARKit's jawOpen (17) and cheekPuff (46), measured, of the first how sure; the head 0.25 m to the left of
/// where the sender's world begins, turned by a right angle to its left.
Packet talking() {
  Packet packet;
  packet.device = 0x024D49454E70;
  packet.sequence = 258;
  packet.battery_percent = 87;
  packet.time = DeviceTime(std::chrono::microseconds(1'234'567));
  packet.face.set = ShapeSet::arkit52;
  packet.face.origin = Origin::measured;
  packet.face.weights[17] = 0.75F;
  packet.face.weights[46] = 0.125F;
  packet.face.confidence[17] = 1;
  packet.face.head = {.position_m = {0.25F, 0, -0.5F},
                      .position_known = true,
                      .rotation = {0.70710677F, 0, 0.70710677F, 0},
                      .confidence = 127.0F / 254};
  return packet;
}

std::vector<std::byte> encoded(const Packet& packet) {
  auto bytes = encode_packet(packet);
  EXPECT_TRUE(bytes) << bytes.error().message();
  return bytes ? *bytes : std::vector<std::byte>();
}

// The test vector of docs/reference/protocol.md: whoever writes a sender checks against the same bytes.
TEST(WeightsPacket, MatchesTheDocumentsBytes) {
  EXPECT_EQ(hex(encoded(talking())),
            "4d49454e010c5707704e45494d020000020100000101027f87d6120000000000"
            "f608dae4000002000040000000000000"
            "0000403f0000003e"
            "feff"
            "0000803e00000000000000bff304353f00000000f304353f00000000"
            "9293f572");
}

TEST(WeightsPacket, TheTableOfSetsIsTheDocuments) {
  const std::array<std::tuple<std::string_view, std::size_t, std::uint32_t>, kShapeSetCount> table = {{
      {"ict53", 54, 0x79ADBAD6},
      {"arkit52", 52, 0xE4DA08F6},
      {"openxr_fb_63", 63, 0x0CE383AA},
      {"openxr_fb_70", 70, 0xF05C49F4},
      {"refa_64", 64, 0xA5EF1CFC},
      {"unified", 88, 0x6056EDE9},
  }};
  for (std::size_t i = 0; i < kShapeSetCount; ++i) {
    const auto set = static_cast<ShapeSet>(i);
    EXPECT_EQ(std::tuple(name_of(set), count_of(set), names_checksum(set)), table[i])
        << std::hex << names_checksum(set);
  }
  EXPECT_EQ(shape_name(ShapeSet::arkit52, 17), "jawOpen");
  EXPECT_EQ(shape_name(ShapeSet::ict53, 53), "tongueOut");
  EXPECT_FALSE(shape_set(6));
}

TEST(WeightsPacket, ComesBackAsItWentAndFitsADatagram) {
  Random random(7);
  std::size_t most = 0;
  for (int i = 0; i < 300; ++i) {
    Packet packet = talking();
    ToldFace& face = packet.face;
    face = {};
    face.set = static_cast<ShapeSet>(random.below(kShapeSetCount));
    face.origin = static_cast<Origin>(random.below(kOriginCount));
    const double density = random.uniform(0, 1.5);
    for (std::size_t k = 0; k < count_of(face.set); ++k) {
      if (!random.chance(std::min(1.0, density))) continue;
      face.weights[k] = static_cast<float>(random.uniform(-0.5, 1.5));
      if (random.chance(0.5)) face.confidence[k] = static_cast<float>(random.below(255)) / 254;
    }
    if (random.chance(0.7)) {
      const Quat q = exp_rotation({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
      face.head = {.position_m = {1, 2, static_cast<float>(random.uniform(-100, 100))},
                   .position_known = true,
                   .rotation = {static_cast<float>(q.w()), static_cast<float>(q.x()),
                                static_cast<float>(q.y()), static_cast<float>(q.z())}};
      if (random.chance(0.5)) face.head->confidence = static_cast<float>(random.below(255)) / 254;
      if (random.chance(0.3)) {
        face.head->position_known = false;
        face.head->position_m.setZero();
      }
    }
    const auto bytes = encoded(packet);
    most = std::max(most, bytes.size());
    EXPECT_TRUE(is_packet(bytes));
    const auto back = parse_packet(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, packet);
    EXPECT_EQ(encoded(*back), bytes);

    // And by way of samples.
    std::array<sensor::Sample, kMostParts> samples;
    ToldFace from_samples;
    const std::size_t used = samples_of(face, samples);
    for (std::size_t s = 0; s < used; ++s) ASSERT_TRUE(add_sample(samples[s], from_samples)) << s;
    if (used == 0) continue;
    if (face.told() == 0) from_samples.set = face.set;  // No sample says of what set nothing is told.
    EXPECT_EQ(from_samples, face);
  }
  EXPECT_LE(most, kMostPacketBytes);
  EXPECT_LE(kMostPacketBytes, 1024U) << "what a sealed packet holds";
}

TEST(WeightsPacket, RefusesEveryTruncationAndTrailingBytes) {
  expect_refuses_truncation_and_trailing_bytes(encoded(talking()), parse_packet);
}

TEST(WeightsPacket, RefusesEveryFlippedBit) {
  expect_refuses_flipped_bits(encoded(talking()), parse_packet);
}

TEST(WeightsPacket, RefusesEachWrongFieldAlone) {
  const std::vector<unsigned> nan = {0, 0, 0xc0, 0x7f}, huge = {0xca, 0xf2, 0x49, 0x71},
                              minus_1 = {0, 0, 0x80, 0xbf};
  const std::vector<WrongField> cases = {
      {"magic", 0, {'X'}, ErrorCode::malformed},
      {"version", 4, {2}, ErrorCode::unsupported},
      {"type", 5, {11}, ErrorCode::unsupported},
      {"battery", 6, {101}, ErrorCode::out_of_range},
      {"flag", 7, {15}, ErrorCode::malformed},
      {"a position without its flag", 7, {3}, ErrorCode::out_of_range},
      {"set", 20, {6}, ErrorCode::unsupported},
      {"another set's names", 20, {2}, ErrorCode::mismatch},
      {"names", 32, {1}, ErrorCode::mismatch},
      {"origin", 21, {5}, ErrorCode::out_of_range},
      {"time", 24, {0x01, 0x40, 0x7a, 0x10, 0xf3, 0x5a, 0, 0}, ErrorCode::out_of_range},
      {"a third shape", 36, {1}, ErrorCode::malformed},
      {"a shape that the set does not have", 38, {0, 0, 0, 0, 0, 0x40, 0x10}, ErrorCode::malformed},
      {"weight is not a number", 48, nan, ErrorCode::out_of_range},
      {"weight of 1e30", 48, huge, ErrorCode::out_of_range},
      {"weight of -1", 48, minus_1, ErrorCode::out_of_range},
      {"position is not a number", 58, nan, ErrorCode::out_of_range},
      {"position of 1e30", 62, huge, ErrorCode::out_of_range},
      {"rotation is not a number", 70, nan, ErrorCode::out_of_range},
      {"rotation of 1e30", 74, huge, ErrorCode::out_of_range},
      {"rotation of length 1.2", 70, minus_1, ErrorCode::out_of_range},
  };
  expect_refuses_wrong_fields(encoded(talking()), cases, parse_packet);

  Packet faceless = talking();
  faceless.face.head.reset();
  expect_refuses_wrong_fields(encoded(faceless),
                              {{"a position without a head", 7, {5}, ErrorCode::malformed},
                               {"confidence of no head", 23, {1}, ErrorCode::malformed}},
                              parse_packet);
}

TEST(WeightsPacket, ASampleOfOtherThingsIsNotTaken) {
  std::array<sensor::Sample, kMostParts> samples;
  ASSERT_EQ(samples_of(talking().face, samples), 4U);
  ToldFace face;
  const auto refuses = [&](std::size_t i, auto change) {
    sensor::Sample sample = samples[i];
    change(sample);
    ToldFace before = face;
    EXPECT_FALSE(add_sample(sample, face));
    EXPECT_EQ(face, before);
  };
  refuses(0, [](auto& s) { s.kind = sensor::SampleKind::gaze; });
  refuses(0, [](auto& s) { s.count = 3; });
  refuses(0, [](auto& s) { s.values[0] = 6; });
  refuses(0, [](auto& s) { s.values[0] = NAN; });
  refuses(0, [](auto& s) { s.values[1] = 0.5F; });
  refuses(0, [](auto& s) { s.values[2] = 12; });
  refuses(0, [](auto& s) { s.values[2] = 1e30F; });
  refuses(0, [](auto& s) { s.values[5] = 1.6F; });
  refuses(2, [](auto&) {});  // A confidence of a weight that is not told.
  refuses(3, [](auto& s) { s.values[3] = 2; });
  refuses(3, [](auto& s) { s.values[9] = 0; });
  ASSERT_TRUE(add_sample(samples[0], face));
  refuses(1, [](auto& s) { s.values[0] = 2; });  // Half of a face of one set, half of another.
}

}  // namespace
}  // namespace mien::phone::packet_test
