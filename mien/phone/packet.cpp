#include "mien/phone/packet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "mien/core/bytes.h"

namespace mien::phone {
namespace {

constexpr std::uint8_t kTypeWeights = 12;
const char* const kWeightsPacket = "weights packet";

constexpr std::uint8_t kHasConfidence = 1;
constexpr std::uint8_t kHasHead = 2;
constexpr std::uint8_t kHasPosition = 4;
constexpr std::uint8_t kAllFlags = kHasConfidence | kHasHead | kHasPosition;
constexpr std::size_t kHeadBytes = 28;
/// A bit a shape, lowest bit of the first byte first.
constexpr std::size_t kPresentBytes = 12;
static_assert(8 * kPresentBytes >= kMostShapes);

/// Confidences, of which some are not told.
std::uint8_t confidence_steps(float confidence) {
  return confidence == kUntold ? sensor::kShareUnknown : sensor::share_steps(confidence);
}

float confidence_of_steps(std::uint8_t steps) {
  return steps == sensor::kShareUnknown ? kUntold : sensor::share_of(steps);
}

Result<void> check(const Packet& packet) {
  MIEN_TRY(sensor::check_battery(packet.battery_percent, kWeightsPacket));
  MIEN_TRY(sensor::check_device_time(packet.time, kWeightsPacket));
  if (!is_sound(packet.face))
    return fail(ErrorCode::out_of_range,
                "a weight, confidence, position or rotation is not finite or beyond its range",
                kWeightsPacket);
  return {};
}

/// Which shapes of a set are told, by their numbers.
struct Present {
  std::array<std::uint8_t, kPresentBytes> bits{};
  [[nodiscard]] bool has(std::size_t shape) const { return (bits[shape / 8] >> (shape % 8) & 1U) != 0; }
  void set(std::size_t shape) { bits[shape / 8] |= static_cast<std::uint8_t>(1U << (shape % 8)); }
};

/// Whether as many bits are set as there are told shapes, and none behind the set's last.
bool fits(const Present& present, std::size_t told, std::size_t count) {
  std::size_t all = 0;
  for (std::size_t i = 0; i < 8 * kPresentBytes; ++i) {
    if (!present.has(i)) continue;
    if (i >= count) return false;
    ++all;
  }
  return all == told;
}

ToldHead read_head(ByteReader& reader, bool position_known, float confidence) {
  ToldHead head;
  for (float& x : head.position_m) x = reader.little<float>();
  for (float& q : head.rotation) q = reader.little<float>();
  head.position_known = position_known;
  head.confidence = confidence;
  return head;
}

}  // namespace

bool is_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeWeights);
}

Result<Packet> parse_packet(std::span<const std::byte> bytes) {
  const auto malformed = [](const char* what) { return fail(ErrorCode::malformed, what, kWeightsPacket); };
  if (bytes.size() < kLeastPacketBytes)
    return fail(ErrorCode::truncated,
                fmt::format("{} bytes, not {} or more", bytes.size(), kLeastPacketBytes), kWeightsPacket);
  ByteReader reader(bytes);
  MIEN_TRY(sensor::read_packet_begin(reader, kTypeWeights, "not weights'", kWeightsPacket));

  Packet packet;
  ToldFace& face = packet.face;
  packet.battery_percent = reader.little<std::uint8_t>();
  const auto flags = reader.little<std::uint8_t>();
  packet.device = reader.little<std::uint64_t>();
  packet.sequence = reader.little<std::uint32_t>();
  const auto set = reader.little<std::uint8_t>();
  const auto origin = reader.little<std::uint8_t>();
  const auto told = reader.little<std::uint8_t>();
  const auto head_confidence = reader.little<std::uint8_t>();
  const bool has_confidence = (flags & kHasConfidence) != 0;
  const bool has_head = (flags & kHasHead) != 0;
  const std::size_t shape_bytes = has_confidence ? 5 : 4;
  MIEN_TRY(sensor::check_length(
      bytes.size(), kLeastPacketBytes + told * shape_bytes + (has_head ? kHeadBytes : 0), kWeightsPacket));
  MIEN_TRY(sensor::check_checksum(bytes, kWeightsPacket));
  if ((flags & ~kAllFlags) != 0) return malformed("an unknown flag is set");
  if (!has_head && ((flags & kHasPosition) != 0 || head_confidence != 0))
    return malformed("something is told of a head that is not there");
  MIEN_TRY_ASSIGN(packet.time, sensor::read_device_time(reader, kWeightsPacket));
  const auto of = shape_set(set);
  if (!of)
    return fail(ErrorCode::unsupported, fmt::format("shape set {} is unknown", set), kWeightsPacket,
                "update this program");
  face.set = *of;
  if (origin >= kOriginCount)
    return fail(ErrorCode::out_of_range, fmt::format("origin {} is unknown", origin), kWeightsPacket);
  face.origin = static_cast<Origin>(origin);
  if (reader.little<std::uint32_t>() != names_checksum(face.set))
    return fail(ErrorCode::mismatch,
                fmt::format("the sender's {} has other names, or another order", name_of(face.set)),
                kWeightsPacket, "the order is what mien face profiles prints");
  Present present;
  for (std::uint8_t& bits : present.bits) bits = reader.little<std::uint8_t>();
  const std::size_t count = count_of(face.set);
  if (!fits(present, told, count)) return malformed("the shapes marked are not those that are told");
  for (std::size_t i = 0; i < count; ++i) {
    if (!present.has(i)) continue;
    face.weights[i] = reader.little<float>();
    if (face.weights[i] == kUntold) return fail(ErrorCode::out_of_range, "a weight of -1", kWeightsPacket);
  }
  for (std::size_t i = 0; i < count && has_confidence; ++i)
    if (present.has(i)) face.confidence[i] = confidence_of_steps(reader.little<std::uint8_t>());
  if (has_head)
    face.head = read_head(reader, (flags & kHasPosition) != 0, confidence_of_steps(head_confidence));
  MIEN_TRY(check(packet));
  return packet;
}

Result<std::vector<std::byte>> encode_packet(const Packet& packet) {
  MIEN_TRY(check(packet));
  const ToldFace& face = packet.face;
  const std::size_t count = count_of(face.set);
  const bool has_confidence = std::ranges::any_of(face.confidence, [](float c) { return c != kUntold; });
  std::uint8_t flags = has_confidence ? kHasConfidence : 0;
  if (face.head) flags |= kHasHead;
  if (face.head && face.head->position_known) flags |= kHasPosition;
  Present present;
  for (std::size_t i = 0; i < count; ++i)
    if (face.weights[i] != kUntold) present.set(i);

  ByteWriter writer;
  sensor::write_packet_begin(kTypeWeights, writer);
  writer.little(packet.battery_percent);
  writer.little(flags);
  writer.little(packet.device);
  writer.little(packet.sequence);
  writer.little(static_cast<std::uint8_t>(face.set));
  writer.little(static_cast<std::uint8_t>(face.origin));
  writer.little(static_cast<std::uint8_t>(face.told()));
  writer.little(face.head ? confidence_steps(face.head->confidence) : std::uint8_t{0});
  sensor::write_device_time(packet.time, writer);
  writer.little(names_checksum(face.set));
  for (const std::uint8_t bits : present.bits) writer.little(bits);
  for (std::size_t i = 0; i < count; ++i)
    if (present.has(i)) writer.little(face.weights[i]);
  for (std::size_t i = 0; i < count && has_confidence; ++i)
    if (present.has(i)) writer.little(confidence_steps(face.confidence[i]));
  if (face.head) {
    for (const float x : face.head->position_m) writer.little(x);
    for (const float q : face.head->rotation) writer.little(q);
  }
  sensor::write_checksum(0, writer);
  return writer.release();
}

}  // namespace mien::phone
