#include "mien/headset/picture_packet.h"

#include "mien/sensor/packet_envelope.h"

namespace mien::headset {
namespace {

constexpr std::uint8_t kTypePicture = 15;
const char* const kPicturePacket = "picture packet";
constexpr unsigned kTimeKnown = 1;
constexpr unsigned kFirst = 2;

}  // namespace

bool is_picture_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypePicture);
}

Result<PicturePacket> parse_picture_packet(std::span<const std::byte> bytes) {
  MIEN_TRY(sensor::check_length(bytes.size(), kPicturePacketBytes, kPicturePacket));
  ByteReader reader(bytes);
  MIEN_TRY(sensor::read_packet_begin(reader, kTypePicture, "not a picture's", kPicturePacket));
  MIEN_TRY(sensor::check_checksum(bytes, kPicturePacket));

  PicturePacket packet;
  const unsigned flags = reader.little<std::uint8_t>();
  packet.from.channel = reader.little<std::uint8_t>();
  packet.from.device = reader.little<std::uint64_t>();
  packet.sequence = reader.little<std::uint32_t>();
  if ((flags & ~(kTimeKnown | kFirst)) != 0 || reader.little<std::uint32_t>() != 0)
    return fail(ErrorCode::malformed, "a reserved bit is set", kPicturePacket);
  packet.first = (flags & kFirst) != 0;
  MIEN_TRY_ASSIGN(const DeviceTime time, sensor::read_device_time(reader, kPicturePacket));
  if ((flags & kTimeKnown) != 0)
    packet.time = time;
  else if (time != DeviceTime())
    return fail(ErrorCode::malformed, "a time where none is known", kPicturePacket);
  return packet;
}

Result<void> write_picture_packet(const PicturePacket& packet, ByteWriter& out) {
  if (packet.time) MIEN_TRY(sensor::check_device_time(*packet.time, kPicturePacket));
  const std::size_t begin = out.bytes().size();
  sensor::write_packet_begin(kTypePicture, out);
  out.little(static_cast<std::uint8_t>((packet.time ? kTimeKnown : 0U) | (packet.first ? kFirst : 0U)));
  out.little(packet.from.channel);
  out.little(packet.from.device);
  out.little(packet.sequence);
  out.little(std::uint32_t{0});
  sensor::write_device_time(packet.time.value_or(DeviceTime()), out);
  sensor::write_checksum(begin, out);
  return {};
}

}  // namespace mien::headset
