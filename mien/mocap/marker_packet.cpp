#include "mien/mocap/marker_packet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/mocap/marker_track.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::mocap {
namespace {

using sensor::kChecksumBytes;

constexpr std::uint8_t kTypeNames = 9;
constexpr std::uint8_t kTypePositions = 10;
constexpr std::size_t kNamesHeaderBytes = 21;
constexpr std::size_t kPositionsHeaderBytes = 32;
constexpr std::size_t kPositionBytes = 12;
constexpr std::size_t kMostNamesBytes = 1200;
constexpr double kUmPerM = 1e6;
constexpr std::int32_t kLostUm = std::numeric_limits<std::int32_t>::min();

const char* const kMarkerPacket = "marker packet";

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxMarkerNameBytes &&
         std::ranges::all_of(name,
                             [](unsigned char c) { return c >= 0x20 && c < 0x7F && c != ',' && c != '"'; });
}

Result<void> check_count(std::size_t markers) {
  if (markers >= 1 && markers <= kMaxPacketMarkers) return {};
  return fail(ErrorCode::out_of_range, fmt::format("{} markers, not 1 to {}", markers, kMaxPacketMarkers),
              kMarkerPacket);
}

Result<MarkerPacket> parse_names(ByteReader reader) {
  MarkerNamesPacket packet;
  packet.markers = reader.little<std::uint8_t>();
  packet.first = reader.little<std::uint8_t>();
  packet.device = reader.little<std::uint64_t>();
  packet.list = reader.little<std::uint32_t>();
  packet.count = reader.little<std::uint8_t>();
  MIEN_TRY(check_count(packet.markers));
  if (packet.count < 1 || packet.first + packet.count > packet.markers)
    return fail(ErrorCode::out_of_range, "names of markers that are none", kMarkerPacket);
  for (std::size_t i = 0; i < packet.count; ++i) {
    const std::span<const std::byte> text = reader.take(reader.little<std::uint8_t>());
    packet.names[i] = {reinterpret_cast<const char*>(text.data()), text.size()};
    if (!reader.ok()) return fail(ErrorCode::truncated, "its names are cut short", kMarkerPacket);
    if (!is_name(packet.names[i])) return fail(ErrorCode::malformed, "a name that is none", kMarkerPacket);
  }
  if (reader.left() > 0) return fail(ErrorCode::malformed, "bytes behind its names", kMarkerPacket);
  return packet;
}

Result<MarkerPacket> parse_positions(ByteReader reader) {
  MarkerPositionsPacket packet;
  packet.count = reader.little<std::uint8_t>();
  if (reader.little<std::uint8_t>() != 0)
    return fail(ErrorCode::malformed, "a reserved byte is set", kMarkerPacket);
  packet.device = reader.little<std::uint64_t>();
  packet.sequence = reader.little<std::uint32_t>();
  packet.list = reader.little<std::uint32_t>();
  MIEN_TRY_ASSIGN(packet.time, sensor::read_device_time(reader, kMarkerPacket));
  MIEN_TRY(check_count(packet.count));
  if (reader.left() != packet.count * kPositionBytes)
    return fail(reader.left() < packet.count * kPositionBytes ? ErrorCode::truncated : ErrorCode::malformed,
                fmt::format("{} bytes of positions, not {}", reader.left(), packet.count * kPositionBytes),
                kMarkerPacket);
  for (std::size_t i = 0; i < packet.count; ++i) {
    std::array<std::int32_t, 3> um{};
    for (std::int32_t& axis : um) axis = reader.little<std::int32_t>();
    const auto lost = std::ranges::count(um, kLostUm);
    if (lost != 0 && lost != 3) return fail(ErrorCode::malformed, "half a position", kMarkerPacket);
    const Vec3 position_m = Vec3(um[0], um[1], um[2]) / kUmPerM;
    if (lost == 0 && position_m.cwiseAbs().maxCoeff() > kMaxTrackPositionM)
      return fail(ErrorCode::out_of_range, "a marker far away", kMarkerPacket);
    packet.position_m[i] = lost == 3 ? kLostMarker : Vec3f(position_m.cast<float>());
  }
  return packet;
}

}  // namespace

bool is_marker_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeNames) || sensor::is_our_packet(bytes, kTypePositions);
}

Result<MarkerPacket> parse_marker_packet(std::span<const std::byte> bytes) {
  if (bytes.size() < kNamesHeaderBytes + kChecksumBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are too few", bytes.size()), kMarkerPacket);
  ByteReader reader(bytes.first(bytes.size() - kChecksumBytes));
  MIEN_TRY_ASSIGN(const std::uint8_t type, sensor::read_packet_begin(reader, kMarkerPacket));
  if (type != kTypeNames && type != kTypePositions)
    return fail(ErrorCode::unsupported, fmt::format("packet type {} is not of markers", type), kMarkerPacket);
  if (type == kTypePositions && bytes.size() < kPositionsHeaderBytes + kPositionBytes + kChecksumBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are too few", bytes.size()), kMarkerPacket);
  MIEN_TRY(sensor::check_checksum(bytes, kMarkerPacket));
  return type == kTypeNames ? parse_names(reader) : parse_positions(reader);
}

std::uint32_t marker_list(std::span<const std::string> names) {
  std::string all;
  for (const std::string& name : names) all += name + '\n';
  return crc32(std::as_bytes(std::span(all)));
}

Result<std::vector<std::vector<std::byte>>> encode_marker_names(std::uint64_t device,
                                                                std::span<const std::string> names) {
  MIEN_TRY(check_count(names.size()));
  for (const std::string& name : names)
    if (!is_name(name))
      return fail(ErrorCode::malformed, fmt::format("'{}' cannot name a marker", excerpt(name)),
                  kMarkerPacket);
  std::vector<std::vector<std::byte>> packets;
  for (std::size_t first = 0; first < names.size();) {
    std::size_t end = first, bytes = kNamesHeaderBytes + kChecksumBytes;
    while (end < names.size() && bytes + 1 + names[end].size() <= kMostNamesBytes)
      bytes += 1 + names[end++].size();
    ByteWriter writer;
    sensor::write_packet_begin(kTypeNames, writer);
    writer.little(static_cast<std::uint8_t>(names.size()));
    writer.little(static_cast<std::uint8_t>(first));
    writer.little(device);
    writer.little(marker_list(names));
    writer.little(static_cast<std::uint8_t>(end - first));
    for (; first < end; ++first) {
      writer.little(static_cast<std::uint8_t>(names[first].size()));
      writer.append(std::string_view(names[first]));
    }
    sensor::write_checksum(0, writer);
    packets.push_back(writer.release());
  }
  return packets;
}

Result<std::vector<std::byte>> encode_marker_positions(const MarkerPositionsPacket& packet) {
  MIEN_TRY(check_count(packet.count));
  MIEN_TRY(sensor::check_device_time(packet.time, kMarkerPacket));
  ByteWriter writer;
  sensor::write_packet_begin(kTypePositions, writer);
  writer.little(packet.count);
  writer.little(std::uint8_t{0});
  writer.little(packet.device);
  writer.little(packet.sequence);
  writer.little(packet.list);
  sensor::write_device_time(packet.time, writer);
  for (std::size_t i = 0; i < packet.count; ++i) {
    const Vec3 position_m = packet.position_m[i].cast<double>();
    if (is_seen(packet.position_m[i]) && position_m.cwiseAbs().maxCoeff() > kMaxTrackPositionM)
      return fail(ErrorCode::out_of_range, "a marker far away", kMarkerPacket);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      writer.little(is_seen(packet.position_m[i])
                        ? static_cast<std::int32_t>(std::lround(kUmPerM * position_m[axis]))
                        : kLostUm);
  }
  sensor::write_checksum(0, writer);
  return writer.release();
}

}  // namespace mien::mocap
