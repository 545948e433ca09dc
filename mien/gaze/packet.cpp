#include "mien/gaze/packet.h"

#include <cmath>

#include "mien/core/bytes.h"

namespace mien::gaze {
namespace {

constexpr std::uint8_t kTypeGaze = 11;
const char* const kGazePacket = "gaze packet";

constexpr float kPupilStepsPerMm = 100;
constexpr std::uint16_t kPupilUnknown = 0xFFFF;

Result<void> check(const Packet& packet) {
  MIEN_TRY(sensor::check_battery(packet.battery_percent, kGazePacket));
  MIEN_TRY(sensor::check_device_time(packet.time, kGazePacket));
  for (const Eye& eye : packet.eyes)
    if (!is_sound(eye))
      return fail(ErrorCode::out_of_range,
                  "an eye's angle, openness, pupil or confidence is beyond its range", kGazePacket);
  return {};
}

void write_eye(const Eye& eye, ByteWriter& out) {
  out.little(eye.yaw_rad);
  out.little(eye.pitch_rad);
  out.little(eye.openness ? sensor::share_steps(*eye.openness) : sensor::kShareUnknown);
  out.little(sensor::share_steps(eye.confidence));
  out.little(eye.pupil_mm ? static_cast<std::uint16_t>(std::lround(*eye.pupil_mm * kPupilStepsPerMm))
                          : kPupilUnknown);
}

Result<Eye> read_eye(ByteReader& reader) {
  Eye eye;
  eye.yaw_rad = reader.little<float>();
  eye.pitch_rad = reader.little<float>();
  const auto openness = reader.little<std::uint8_t>();
  const auto confidence = reader.little<std::uint8_t>();
  const auto pupil = reader.little<std::uint16_t>();
  if (confidence > sensor::kShareSteps)
    return fail(ErrorCode::out_of_range, "a confidence above 254 steps", kGazePacket);
  if (openness != sensor::kShareUnknown) eye.openness = sensor::share_of(openness);
  eye.confidence = sensor::share_of(confidence);
  if (pupil != kPupilUnknown) eye.pupil_mm = static_cast<float>(pupil) / kPupilStepsPerMm;
  return eye;
}

}  // namespace

bool is_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeGaze);
}

Result<Packet> parse_packet(std::span<const std::byte> bytes) {
  MIEN_TRY(sensor::check_length(bytes.size(), kPacketBytes, kGazePacket));
  ByteReader reader(bytes);
  MIEN_TRY(sensor::read_packet_begin(reader, kTypeGaze, "not gaze's", kGazePacket));
  MIEN_TRY(sensor::check_checksum(bytes, kGazePacket));

  Packet packet;
  packet.battery_percent = reader.little<std::uint8_t>();
  bool reserved = reader.little<std::uint8_t>() != 0;
  packet.device = reader.little<std::uint64_t>();
  packet.sequence = reader.little<std::uint32_t>();
  reserved = reader.little<std::uint32_t>() != 0 || reserved;
  if (reserved) return fail(ErrorCode::malformed, "a reserved byte is set", kGazePacket);
  MIEN_TRY_ASSIGN(packet.time, sensor::read_device_time(reader, kGazePacket));
  for (Eye& eye : packet.eyes) {
    MIEN_TRY_ASSIGN(eye, read_eye(reader));
  }
  MIEN_TRY(check(packet));
  return packet;
}

Result<std::vector<std::byte>> encode_packet(const Packet& packet) {
  MIEN_TRY(check(packet));
  ByteWriter writer;
  sensor::write_packet_begin(kTypeGaze, writer);
  writer.little(packet.battery_percent);
  writer.little(std::uint8_t{0});
  writer.little(packet.device);
  writer.little(packet.sequence);
  writer.little(std::uint32_t{0});
  sensor::write_device_time(packet.time, writer);
  for (const Eye& eye : packet.eyes) write_eye(eye, writer);
  sensor::write_checksum(0, writer);
  return writer.release();
}

}  // namespace mien::gaze
