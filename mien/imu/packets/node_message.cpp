#include "mien/imu/packets/node_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mien/sensor/packet_envelope.h"
#include "mien/sensor/seal.h"

namespace mien::imu {
namespace {

using sensor::kChecksumBytes;

static_assert(static_cast<std::uint8_t>(NodePacketType::hello) == sensor::kHelloPacketType);
static_assert(static_cast<std::uint8_t>(NodePacketType::sealed) == sensor::kSealedPacketType);

constexpr std::size_t kNodeHeaderBytes = 16;
constexpr std::uint32_t kMinRateMilliHz = 1'000;
constexpr std::uint32_t kMaxRateMilliHz = 10'000'000;
constexpr std::uint16_t kMinHeartbeatMs = 100;
constexpr std::uint16_t kMaxHeartbeatMs = 10'000;

const char* const kNodePacket = "node packet";

bool is_plain(std::string_view text) {
  return text.size() <= kMaxNodeText &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

/// A length and that many bytes; text that is not printable ASCII is malformed.
Result<std::string> read_text(ByteReader& reader) {
  const auto size = reader.little<std::uint8_t>();
  const auto bytes = reader.take(size);
  std::string text(bytes.size(), ' ');
  std::transform(bytes.begin(), bytes.end(), text.begin(),
                 [](std::byte b) { return static_cast<char>(std::to_integer<unsigned char>(b)); });
  if (!is_plain(text)) return fail(ErrorCode::malformed, "a text that is too long or not plain", kNodePacket);
  return text;
}

void write_text(std::string_view text, ByteWriter& out) {
  out.little(static_cast<std::uint8_t>(text.size()));
  out.append(text);
}

// Checks for parsing and encoding.

Result<void> check_text(std::string_view text) {
  if (!is_plain(text)) return fail(ErrorCode::malformed, "a text that is too long or not plain", kNodePacket);
  return {};
}

Result<void> check(const Hello& hello) {
  if (hello.sites.empty() || hello.sites.size() > kMaxNodeChannels)
    return fail(ErrorCode::out_of_range,
                fmt::format("{} channels, not 1 to {}", hello.sites.size(), kMaxNodeChannels), kNodePacket);
  if (!(hello.rate_hz * 1000 >= kMinRateMilliHz && hello.rate_hz * 1000 <= kMaxRateMilliHz))
    return fail(ErrorCode::out_of_range, "a sample rate out of range", kNodePacket);
  MIEN_TRY(check_text(hello.firmware));
  for (const std::string& site : hello.sites) MIEN_TRY(check_text(site));
  return {};
}

Result<void> check(const Welcome& welcome) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(welcome.heartbeat).count();
  if (ms < kMinHeartbeatMs || ms > kMaxHeartbeatMs)
    return fail(ErrorCode::out_of_range, "a heartbeat's period out of range", kNodePacket);
  if (welcome.session == 0) return fail(ErrorCode::malformed, "a session without a token", kNodePacket);
  return check_text(welcome.host);
}

Result<void> check(const NodeHeartbeat& heartbeat) {
  MIEN_TRY(sensor::check_battery(heartbeat.battery_percent, kNodePacket));
  return sensor::check_device_time(heartbeat.time, kNodePacket);
}

Result<void> check(const HeartbeatEcho& echo) {
  if (echo.session == 0) return fail(ErrorCode::malformed, "a session without a token", kNodePacket);
  return sensor::check_device_time(echo.time, kNodePacket);
}

Result<void> check(const Pulse& pulse) {
  return sensor::check_device_time(pulse.edge, kNodePacket);
}

// Bodies, between header and checksum. The seventh byte is a heartbeat's battery; 0 in the others.

Result<NodeMessage> read_hello(std::uint64_t device, ByteReader& reader) {
  Hello hello;
  hello.device = device;
  hello.rate_hz = reader.little<std::uint32_t>() / 1000.0;
  const auto channels = reader.little<std::uint8_t>();
  if (channels > kMaxNodeChannels) return fail(ErrorCode::out_of_range, "too many channels", kNodePacket);
  MIEN_TRY_ASSIGN(hello.firmware, read_text(reader));
  for (int i = 0; i < channels; ++i) {
    MIEN_TRY_ASSIGN(std::string site, read_text(reader));
    hello.sites.push_back(std::move(site));
  }
  return hello;
}

Result<NodeMessage> read_welcome(std::uint64_t device, ByteReader& reader) {
  Welcome welcome;
  welcome.device = device;
  welcome.session = reader.little<std::uint64_t>();
  welcome.heartbeat = std::chrono::milliseconds(reader.little<std::uint16_t>());
  MIEN_TRY_ASSIGN(welcome.host, read_text(reader));
  return welcome;
}

Result<NodeMessage> read_heartbeat(std::uint64_t device, std::uint8_t battery, ByteReader& reader) {
  NodeHeartbeat heartbeat{.device = device, .battery_percent = battery};
  MIEN_TRY_ASSIGN(heartbeat.time, sensor::read_device_time(reader, kNodePacket));
  return heartbeat;
}

Result<NodeMessage> read_echo(std::uint64_t device, ByteReader& reader) {
  HeartbeatEcho echo{.device = device};
  MIEN_TRY_ASSIGN(echo.time, sensor::read_device_time(reader, kNodePacket));
  echo.session = reader.little<std::uint64_t>();
  return echo;
}

Result<NodeMessage> read_pulse(std::uint64_t device, ByteReader& reader) {
  Pulse pulse{.device = device};
  MIEN_TRY_ASSIGN(pulse.edge, sensor::read_device_time(reader, kNodePacket));
  pulse.index = reader.little<std::uint32_t>();
  return pulse;
}

void write_header(NodePacketType type, std::uint8_t seventh, std::uint64_t device, ByteWriter& out) {
  sensor::write_packet_begin(static_cast<std::uint8_t>(type), out);
  out.little(seventh);
  out.little(std::uint8_t{0});
  out.little(device);
}

void write(const Hello& hello, ByteWriter& out) {
  write_header(NodePacketType::hello, 0, hello.device, out);
  out.little(static_cast<std::uint32_t>(std::lround(hello.rate_hz * 1000)));
  out.little(static_cast<std::uint8_t>(hello.sites.size()));
  write_text(hello.firmware, out);
  for (const std::string& site : hello.sites) write_text(site, out);
}

void write(const Welcome& welcome, ByteWriter& out) {
  write_header(NodePacketType::welcome, 0, welcome.device, out);
  out.little(welcome.session);
  out.little(static_cast<std::uint16_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(welcome.heartbeat).count()));
  write_text(welcome.host, out);
}

void write(const NodeHeartbeat& heartbeat, ByteWriter& out) {
  write_header(NodePacketType::heartbeat, heartbeat.battery_percent, heartbeat.device, out);
  sensor::write_device_time(heartbeat.time, out);
}

void write(const HeartbeatEcho& echo, ByteWriter& out) {
  write_header(NodePacketType::echo, 0, echo.device, out);
  sensor::write_device_time(echo.time, out);
  out.little(echo.session);
}

void write(const Pulse& pulse, ByteWriter& out) {
  write_header(NodePacketType::pulse, 0, pulse.device, out);
  sensor::write_device_time(pulse.edge, out);
  out.little(pulse.index);
}

Result<NodeMessage> read_body(NodePacketType type, std::uint64_t device, std::uint8_t seventh,
                              ByteReader& reader) {
  switch (type) {
    case NodePacketType::hello:
      return read_hello(device, reader);
    case NodePacketType::welcome:
      return read_welcome(device, reader);
    case NodePacketType::heartbeat:
      return read_heartbeat(device, seventh, reader);
    case NodePacketType::echo:
      return read_echo(device, reader);
    case NodePacketType::pulse:
      return read_pulse(device, reader);
    case NodePacketType::samples:
    case NodePacketType::sealed:
      break;
  }
  return fail(ErrorCode::unsupported, fmt::format("packet type {} is unknown here", static_cast<int>(type)),
              kNodePacket);
}

}  // namespace

bool is_node_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes);
}

Result<NodeMessage> parse_node_message(std::span<const std::byte> bytes) {
  if (bytes.size() < kNodeHeaderBytes + kChecksumBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are too few", bytes.size()), kNodePacket);
  ByteReader reader(bytes.first(bytes.size() - kChecksumBytes));
  MIEN_TRY_ASSIGN(const std::uint8_t type_byte, sensor::read_packet_begin(reader, kNodePacket));
  MIEN_TRY(sensor::check_checksum(bytes, kNodePacket));

  const auto type = static_cast<NodePacketType>(type_byte);
  const auto seventh = reader.little<std::uint8_t>();
  const auto eighth = reader.little<std::uint8_t>();
  const auto device = reader.little<std::uint64_t>();
  MIEN_TRY_ASSIGN(NodeMessage message, read_body(type, device, seventh, reader));
  if ((seventh != 0 && type != NodePacketType::heartbeat) || eighth != 0)
    return fail(ErrorCode::malformed, "a reserved byte is set", kNodePacket);
  if (!reader.ok()) return fail(ErrorCode::truncated, "the packet ends too early", kNodePacket);
  if (reader.left() > 0)
    return fail(ErrorCode::malformed, fmt::format("{} bytes too many", reader.left()), kNodePacket);
  MIEN_TRY(std::visit([](const auto& m) { return check(m); }, message));
  return message;
}

Result<void> encode_node_message(const NodeMessage& message, ByteWriter& out) {
  MIEN_TRY(std::visit([](const auto& m) { return check(m); }, message));
  const std::size_t begin = out.bytes().size();
  std::visit([&](const auto& m) { write(m, out); }, message);
  sensor::write_checksum(begin, out);
  return {};
}

}  // namespace mien::imu
