#include "mien/imu/packets/slimevr.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace mien::imu::slimevr {
namespace {

// Further types on the wire, tracker to server: older rotations, and what holds other messages.
constexpr std::uint32_t kRotationOf0 = 1;
constexpr std::uint32_t kRotationOf1 = 16;
constexpr std::uint32_t kBundle = 100;
constexpr std::uint32_t kCompactBundle = 101;
// Server to tracker.
constexpr std::uint32_t kServerHeartbeat = 1;
constexpr std::uint32_t kPing = 10;

constexpr std::size_t kSlimeVrHeaderBytes = 12;
constexpr std::size_t kGreetingBytes = 64;
constexpr std::size_t kAckBytes = 6;
constexpr std::string_view kGreeting = "Hey OVR =D 5";
constexpr std::size_t kMacBytes = 6;
constexpr double kSlimeVrUnitTolerance = 0.01;
constexpr float kMaxAcceleration = 1000.0F;    // m/s^2, as of our own packets.
constexpr float kRotationStep = 1.0F / 32768;  // Of RotationAndAcceleration.
constexpr float kAccelerationStep = 1.0F / 128;

const char* const kSlimeVrPacket = "SlimeVR packet";

Result<float> finite(float value) {
  if (!std::isfinite(value))
    return fail(ErrorCode::out_of_range, "a number that is not finite", kSlimeVrPacket);
  return value;
}

Result<std::array<float, 4>> unit(const std::array<float, 4>& xyzw) {
  double norm2 = 0;
  for (const float v : xyzw) {
    MIEN_TRY(finite(v));
    norm2 += static_cast<double>(v) * static_cast<double>(v);
  }
  if (!(std::abs(std::sqrt(norm2) - 1.0) <= kSlimeVrUnitTolerance))
    return fail(ErrorCode::malformed, "an orientation that is no unit quaternion", kSlimeVrPacket);
  return xyzw;
}

Result<std::array<float, 3>> bounded(const std::array<float, 3>& m_s2) {
  for (const float v : m_s2)
    if (!(std::abs(v) <= kMaxAcceleration))
      return fail(ErrorCode::out_of_range, "an acceleration out of range", kSlimeVrPacket);
  return m_s2;
}

template <std::size_t N>
std::array<float, N> floats(ByteReader& reader) {
  std::array<float, N> values;
  for (float& v : values) v = reader.big<float>();
  return values;
}

template <std::size_t N>
std::array<float, N> steps(ByteReader& reader, float step) {
  std::array<float, N> values;
  for (float& v : values) v = static_cast<float>(reader.big<std::int16_t>()) * step;
  return values;
}

/// The caller detects truncation: missing values read as zeros, which are no unit quaternion.
Result<TrackerMessage> read_rotation(Rotation rotation, ByteReader& reader) {
  const auto xyzw = floats<4>(reader);
  if (!reader.ok()) return fail(ErrorCode::truncated, "a rotation is cut short", kSlimeVrPacket);
  MIEN_TRY_ASSIGN(rotation.xyzw, unit(xyzw));
  return rotation;
}

/// The next field; 0 where older firmware omits it.
template <class T>
T optional_big(ByteReader& reader) {
  return reader.left() >= sizeof(T) ? reader.big<T>() : T{};
}

Handshake read_handshake(ByteReader& reader) {
  Handshake handshake;
  handshake.board = optional_big<std::uint32_t>(reader);
  handshake.imu = optional_big<std::uint32_t>(reader);
  handshake.mcu = optional_big<std::uint32_t>(reader);
  for (int i = 0; i < 3; ++i) optional_big<std::uint32_t>(reader);
  handshake.protocol = optional_big<std::uint32_t>(reader);
  const std::size_t length = std::min<std::size_t>(optional_big<std::uint8_t>(reader), reader.left());
  for (const std::byte b : reader.take(length)) {
    const auto c = static_cast<char>(std::to_integer<unsigned char>(b));
    if (c == '\0') break;  // Old firmware includes the terminating zero.
    handshake.firmware += c >= ' ' && c <= '~' ? c : '?';
  }
  if (reader.left() >= kMacBytes)
    for (const std::byte octet : reader.take(kMacBytes))
      handshake.mac = handshake.mac << 8U | std::to_integer<std::uint64_t>(octet);
  handshake.tracker_type = optional_big<std::uint8_t>(reader);
  return handshake;
}

/// The fields of messages whose fields stand one after the other, in the order of the wire.
struct Fields {
  static auto of(Heartbeat&) { return std::tie(); }
  static auto of(Acceleration& m) { return std::tie(m.m_s2, m.sensor); }
  static auto of(Pong& m) { return std::tie(m.id); }
  static auto of(Battery& m) { return std::tie(m.volts, m.level); }
  static auto of(Tap& m) { return std::tie(m.sensor, m.value); }
  static auto of(SensorError& m) { return std::tie(m.sensor, m.code); }
  static auto of(SensorInfo& m) {
    return std::tie(m.sensor, m.state, m.imu, m.config, m.calibrated, m.position, m.data_type);
  }
  static auto of(Rotation& m) { return std::tie(m.sensor, m.data_type, m.xyzw, m.accuracy); }
  static auto of(MagnetometerAccuracy& m) { return std::tie(m.sensor, m.accuracy); }
  static auto of(SignalStrength& m) { return std::tie(m.sensor, m.dbm); }
  static auto of(Temperature& m) { return std::tie(m.sensor, m.celsius); }
  static auto of(UserAction& m) { return std::tie(m.action); }
  static auto of(ConfigAck& m) { return std::tie(m.sensor, m.what); }
};

/// Reads a message of plain numbers; older firmware may omit those behind the first `least`.
template <class Message>
Result<TrackerMessage> read_numbers(ByteReader& reader, std::size_t least = 2) {
  Message message;
  std::size_t place = 0;
  bool all_finite = true;
  const auto read = [&]<class T>(T& field) {
    field = place++ < least ? reader.big<T>() : optional_big<T>(reader);
    if constexpr (std::floating_point<T>) all_finite = all_finite && std::isfinite(field);
  };
  std::apply([&](auto&... fields) { (read(fields), ...); }, Fields::of(message));
  if (!all_finite) return fail(ErrorCode::out_of_range, "a number that is not finite", kSlimeVrPacket);
  return message;
}

FeatureFlags read_flags(ByteReader& reader) {
  FeatureFlags flags;
  for (unsigned i = 0; i < 4; ++i)
    flags.bits |= static_cast<std::uint32_t>(optional_big<std::uint8_t>(reader)) << (8 * i);
  return flags;
}

/// Reads a message; the caller detects truncation.
Result<TrackerMessage> read_fields(std::uint32_t type, ByteReader& reader) {
  switch (type) {
    case Heartbeat::kType:
      return Heartbeat{};
    case Handshake::kType:
      return read_handshake(reader);
    case Acceleration::kType: {
      Acceleration a;
      MIEN_TRY_ASSIGN(a.m_s2, bounded(floats<3>(reader)));
      a.sensor = optional_big<std::uint8_t>(reader);  // Phones omit it.
      return a;
    }
    case Pong::kType:
      return read_numbers<Pong>(reader);
    case Battery::kType: {
      Battery b;
      MIEN_TRY_ASSIGN(b.volts, finite(reader.big<float>()));
      if (reader.left() == 0) {  // Old firmware sends the level alone.
        b.level = std::exchange(b.volts, 0.0F);
      } else {
        MIEN_TRY_ASSIGN(b.level, finite(reader.big<float>()));
      }
      return b;
    }
    case Tap::kType:
      return read_numbers<Tap>(reader);
    case SensorError::kType:
      return read_numbers<SensorError>(reader);
    case SensorInfo::kType:
      return read_numbers<SensorInfo>(reader);
    case kRotationOf0:
      return read_rotation({.sensor = 0}, reader);
    case kRotationOf1:
      return read_rotation({.sensor = 1}, reader);
    case Rotation::kType: {
      Rotation r{.sensor = reader.big<std::uint8_t>()};
      r.data_type = reader.big<std::uint8_t>();
      MIEN_TRY_ASSIGN(TrackerMessage message, read_rotation(r, reader));
      std::get<Rotation>(message).accuracy = optional_big<std::uint8_t>(reader);
      return message;
    }
    case MagnetometerAccuracy::kType:
      return read_numbers<MagnetometerAccuracy>(reader);
    case SignalStrength::kType:
      return read_numbers<SignalStrength>(reader);
    case Temperature::kType:
      return read_numbers<Temperature>(reader);
    case UserAction::kType:
      return read_numbers<UserAction>(reader);
    case FeatureFlags::kType:
      return read_flags(reader);
    case RotationAndAcceleration::kType: {
      RotationAndAcceleration r{.sensor = reader.big<std::uint8_t>()};
      const auto xyzw = steps<4>(reader, kRotationStep);
      r.m_s2 = steps<3>(reader, kAccelerationStep);
      if (!reader.ok()) return fail(ErrorCode::truncated, "a rotation is cut short", kSlimeVrPacket);
      MIEN_TRY_ASSIGN(r.xyzw, unit(xyzw));
      return r;
    }
    case ConfigAck::kType:
      return read_numbers<ConfigAck>(reader);
    default:
      return Unknown{type};
  }
}

Result<TrackerMessage> read_message(std::uint32_t type, std::span<const std::byte> payload) {
  ByteReader reader(payload);
  MIEN_TRY_ASSIGN(TrackerMessage message, read_fields(type, reader));
  if (!reader.ok())
    return fail(ErrorCode::truncated, fmt::format("type {} is cut short", type), kSlimeVrPacket);
  return message;
}

/// Messages preceded by their lengths, without packet numbers.
template <class Length, class Type>
Result<void> read_bundle(std::span<const std::byte> payload, std::vector<TrackerMessage>& out) {
  ByteReader reader(payload);
  while (reader.left() > 0) {
    const auto length = static_cast<std::size_t>(reader.big<Length>());
    const auto inner = reader.take(length);
    if (!reader.ok()) return fail(ErrorCode::truncated, "a bundle is cut short", kSlimeVrPacket);
    if (length < sizeof(Type))
      return fail(ErrorCode::malformed, "a bundle with an empty message", kSlimeVrPacket);
    const auto type = static_cast<std::uint32_t>(ByteReader(inner).big<Type>());
    if (type == kBundle || type == kCompactBundle)
      return fail(ErrorCode::malformed, "a bundle inside a bundle", kSlimeVrPacket);
    MIEN_TRY_ASSIGN(TrackerMessage message, read_message(type, inner.subspan(sizeof(Type))));
    out.push_back(std::move(message));
  }
  return {};
}

/// Least size of a message of this type after the header, bytes.
std::size_t least_payload(std::uint32_t type) {
  switch (type) {
    case kRotationOf0:
    case kRotationOf1:
      return 16;
    case Acceleration::kType:
      return 12;
    case Pong::kType:
    case Battery::kType:
      return 4;
    case Tap::kType:
    case SensorError::kType:
    case SensorInfo::kType:
    case SignalStrength::kType:
      return 2;
    case Rotation::kType:
      return 18;
    case MagnetometerAccuracy::kType:
    case Temperature::kType:
      return 5;
    case UserAction::kType:
      return 1;
    case RotationAndAcceleration::kType:
      return 15;
    case ConfigAck::kType:
      return 3;
    default:
      return 0;
  }
}

void put_steps(std::span<const float> values, float step, ByteWriter& out) {
  for (const float v : values)
    out.big(static_cast<std::int16_t>(std::clamp(std::round(v / step), -32768.0F, 32767.0F)));
}

void put_text(std::string_view text, ByteWriter& out) {
  out.big(static_cast<std::uint8_t>(text.size()));
  out.append(text);
}

void put(const Handshake& m, ByteWriter& out) {
  for (const std::uint32_t number : {m.board, m.imu, m.mcu, 0U, 0U, 0U, m.protocol}) out.big(number);
  put_text(m.firmware, out);
  for (unsigned octet = kMacBytes; octet-- > 0;) out.big(static_cast<std::uint8_t>(m.mac >> (8 * octet)));
  out.big(m.tracker_type);
  for (int i = 0; i < 5; ++i) put_text("", out);  // Vendor, its address, product, updates' address and name.
}

void put(const FeatureFlags& m, ByteWriter& out) {
  for (unsigned i = 0; i < 4; ++i) out.big(static_cast<std::uint8_t>(m.bits >> (8 * i)));
}

void put(const RotationAndAcceleration& m, ByteWriter& out) {
  out.big(m.sensor);
  put_steps(m.xyzw, kRotationStep, out);
  put_steps(m.m_s2, kAccelerationStep, out);
}

void put(const Unknown&, ByteWriter&) {}

template <class Message>
requires requires(Message& message) {
  Fields::of(message);
}
void put(Message message, ByteWriter& out) {
  const auto write = [&]<class T>(const T& field) {
    if constexpr (std::is_arithmetic_v<T>)
      out.big(field);
    else
      for (const float number : field) out.big(number);
  };
  std::apply([&](const auto&... fields) { (write(fields), ...); }, Fields::of(message));
}

void put_fields(const TrackerMessage& message, ByteWriter& out) {
  std::visit([&](const auto& m) { put(m, out); }, message);
}

template <class Message>
constexpr std::uint32_t type_of(const Message&) {
  return Message::kType;
}
constexpr std::uint32_t type_of(const Unknown& message) {
  return message.type;
}
std::uint32_t type_of(const TrackerMessage& message) {
  return std::visit([](const auto& m) { return type_of(m); }, message);
}

Result<void> check_writable(const TrackerMessage& message) {
  if (std::holds_alternative<Unknown>(message))
    return fail(ErrorCode::bad_usage, "a message of no known type", kSlimeVrPacket);
  if (const auto* handshake = std::get_if<Handshake>(&message); handshake && handshake->firmware.size() > 255)
    return fail(ErrorCode::bad_usage, "a firmware's name that is too long", kSlimeVrPacket);
  return {};
}

bool is_uncounted(const TrackerMessage& message) {
  return std::holds_alternative<Handshake>(message) || std::holds_alternative<Pong>(message);
}

void put_header(std::uint32_t type, std::uint64_t number, ByteWriter& out) {
  out.big(type);
  out.big(number);
}

}  // namespace

bool is_tracker_datagram(std::span<const std::byte> bytes) {
  if (bytes.size() < kSlimeVrHeaderBytes || bytes.size() > kMaxDatagram) return false;
  ByteReader reader(bytes);
  const auto type = reader.big<std::uint32_t>();
  const auto number = reader.big<std::uint64_t>();
  return type < 256 && reader.left() >= least_payload(type) && (type != Handshake::kType || number == 0);
}

Result<Header> parse_tracker_datagram(std::span<const std::byte> bytes, std::vector<TrackerMessage>& out) {
  if (bytes.size() > kMaxDatagram) return fail(ErrorCode::malformed, "too long", kSlimeVrPacket);
  ByteReader reader(bytes);
  Header header;
  header.type = reader.big<std::uint32_t>();
  header.number = reader.big<std::uint64_t>();
  if (!reader.ok()) return fail(ErrorCode::truncated, "the header is cut short", kSlimeVrPacket);
  const auto payload = bytes.subspan(kSlimeVrHeaderBytes);
  const std::size_t before = out.size();
  if (header.type == kBundle || header.type == kCompactBundle) {
    const auto done = header.type == kBundle ? read_bundle<std::uint16_t, std::uint32_t>(payload, out)
                                             : read_bundle<std::uint8_t, std::uint8_t>(payload, out);
    if (!done) {
      out.resize(before);
      return std::unexpected(done.error());
    }
  } else {
    MIEN_TRY_ASSIGN(TrackerMessage message, read_message(header.type, payload));
    out.push_back(std::move(message));
  }
  return header;
}

Result<void> encode_tracker_message(std::uint64_t number, const TrackerMessage& message, ByteWriter& out) {
  MIEN_TRY(check_writable(message));
  put_header(type_of(message), is_uncounted(message) ? 0 : number, out);
  put_fields(message, out);
  return {};
}

Result<void> encode_tracker_bundle(std::uint64_t number, std::span<const TrackerMessage> messages,
                                   ByteWriter& out) {
  if (messages.empty()) return fail(ErrorCode::bad_usage, "a bundle of nothing", kSlimeVrPacket);
  ByteWriter inner;
  std::size_t size = kSlimeVrHeaderBytes;
  for (const TrackerMessage& message : messages) {
    MIEN_TRY(check_writable(message));
    if (is_uncounted(message))
      return fail(ErrorCode::bad_usage, "this does not go into bundles", kSlimeVrPacket);
    inner.clear();
    put_fields(message, inner);
    size += sizeof(std::uint16_t) + sizeof(std::uint32_t) + inner.bytes().size();
  }
  if (size > kMaxDatagram) return fail(ErrorCode::bad_usage, "a bundle of too much", kSlimeVrPacket);
  put_header(kBundle, number, out);
  for (const TrackerMessage& message : messages) {
    inner.clear();
    put_fields(message, inner);
    out.big(static_cast<std::uint16_t>(sizeof(std::uint32_t) + inner.bytes().size()));
    out.big(type_of(message));
    out.append(inner.bytes());
  }
  return {};
}

void encode_server_message(const ServerMessage& message, ByteWriter& out) {
  if (std::holds_alternative<Greeting>(message)) {
    out.big(static_cast<std::uint8_t>(Handshake::kType));
    out.append(kGreeting);
    for (std::size_t i = 1 + kGreeting.size(); i < kGreetingBytes; ++i) out.big(std::uint8_t{0});
  } else if (std::holds_alternative<ServerHeartbeat>(message)) {
    put_header(kServerHeartbeat, 0, out);
  } else if (const auto* ping = std::get_if<Ping>(&message)) {
    put_header(kPing, 0, out);
    out.big(ping->id);
  } else if (const auto* flags = std::get_if<ServerFlags>(&message)) {
    put_header(FeatureFlags::kType, 0, out);
    out.big(flags->bits);
  } else if (const auto* ack = std::get_if<SensorInfoAck>(&message)) {
    out.big(SensorInfo::kType);
    out.big(ack->sensor);
    out.big(ack->state);
  }
}

Result<ServerMessage> parse_server_message(std::span<const std::byte> bytes) {
  if (!bytes.empty() && bytes.front() == std::byte{Handshake::kType}) {
    if (bytes.size() < 1 + kGreeting.size())
      return fail(ErrorCode::truncated, "a greeting is cut short", kSlimeVrPacket);
    const auto words = std::as_bytes(std::span(kGreeting));
    if (!std::equal(words.begin(), words.end(), bytes.begin() + 1))
      return fail(ErrorCode::malformed, "a greeting of other words", kSlimeVrPacket);
    return Greeting{};
  }
  ByteReader reader(bytes);
  const auto type = reader.big<std::uint32_t>();
  if (type == SensorInfo::kType && bytes.size() == kAckBytes) {
    SensorInfoAck ack{.sensor = reader.big<std::uint8_t>()};
    ack.state = reader.big<std::uint8_t>();
    return ack;
  }
  reader.big<std::uint64_t>();
  ServerMessage message = Unknown{type};
  if (type == kServerHeartbeat) message = ServerHeartbeat{};
  if (type == kPing) message = Ping{reader.big<std::uint32_t>()};
  if (type == FeatureFlags::kType) message = ServerFlags{reader.big<std::uint8_t>()};
  if (!reader.ok()) return fail(ErrorCode::truncated, "cut short", kSlimeVrPacket);
  return message;
}

}  // namespace mien::imu::slimevr
