#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/error.h"

/// The packets of SlimeVR's trackers and server, as their firmware (protocol version 22) sends them. All
/// numbers are big-endian. Values stay in their units and frames; imu/packets/slimevr_protocol.h makes
/// samples of them. Layout: docs/reference/slimevr.md.
namespace mien::imu::slimevr {

inline constexpr std::uint16_t kPort = 6969;  ///< UDP, both sides; trackers broadcast their handshake to it.
inline constexpr std::size_t kMaxDatagram = 1472;
inline constexpr std::uint32_t kProtocolVersion = 22;

// Tracker to server. `kType`: the message's number on the wire. `sensor` is the board's number of it; 255 is
// the board itself.

struct Heartbeat {
  static constexpr std::uint32_t kType = 0;
  bool operator==(const Heartbeat&) const = default;
};
struct Handshake {
  static constexpr std::uint32_t kType = 3;
  std::uint32_t board = 4;  ///< 4 is a custom one.
  std::uint32_t imu = 0;
  std::uint32_t mcu = 2;  ///< 2 is an ESP32.
  std::uint32_t protocol = kProtocolVersion;
  std::string firmware;   ///< Printable ASCII, other bytes become '?'; at most 255 characters.
  std::uint64_t mac = 0;  ///< First octet highest; 0 where not given.
  std::uint8_t tracker_type = 0;
  bool operator==(const Handshake&) const = default;
};
struct Acceleration {
  static constexpr std::uint32_t kType = 4;
  std::array<float, 3> m_s2{};  ///< Gravity removed; sensor frame. At most 1000 an axis.
  std::uint8_t sensor = 0;
  bool operator==(const Acceleration&) const = default;
};
struct Pong {
  static constexpr std::uint32_t kType = 10;
  std::uint32_t id = 0;  ///< Of the ping.
  bool operator==(const Pong&) const = default;
};
struct Battery {
  static constexpr std::uint32_t kType = 12;
  float volts = 0;
  float level = 0;  ///< 0 to 1.
  bool operator==(const Battery&) const = default;
};
struct Tap {
  static constexpr std::uint32_t kType = 13;
  std::uint8_t sensor = 0;
  std::uint8_t value = 0;
  bool operator==(const Tap&) const = default;
};
struct SensorError {
  static constexpr std::uint32_t kType = 14;
  std::uint8_t sensor = 0;
  std::uint8_t code = 0;
  bool operator==(const SensorError&) const = default;
};
struct SensorInfo {
  static constexpr std::uint32_t kType = 15;
  std::uint8_t sensor = 0;
  std::uint8_t state = 1;  ///< 0 offline, 1 ok, 2 error.
  std::uint8_t imu = 0;    ///< Older firmware omits the fields from here on; they are then 0.
  std::uint16_t config = 0;
  std::uint8_t calibrated = 0;
  std::uint8_t position = 0;   ///< On the body; no face positions exist.
  std::uint8_t data_type = 0;  ///< 0 rotation.
  bool operator==(const SensorInfo&) const = default;
};
struct Rotation {
  static constexpr std::uint32_t kType = 17;
  std::uint8_t sensor = 0;
  std::uint8_t data_type = 1;   ///< 1 normal, 2 a correction.
  std::array<float, 4> xyzw{};  ///< q_world_sensor, world +Z up; of unit length within 1 %.
  std::uint8_t accuracy = 0;
  bool operator==(const Rotation&) const = default;
};
struct MagnetometerAccuracy {
  static constexpr std::uint32_t kType = 18;
  std::uint8_t sensor = 0;
  float accuracy = 0;
  bool operator==(const MagnetometerAccuracy&) const = default;
};
struct SignalStrength {
  static constexpr std::uint32_t kType = 19;
  std::uint8_t sensor = 255;
  std::int8_t dbm = 0;
  bool operator==(const SignalStrength&) const = default;
};
struct Temperature {
  static constexpr std::uint32_t kType = 20;
  std::uint8_t sensor = 0;
  float celsius = 0;
  bool operator==(const Temperature&) const = default;
};
struct UserAction {
  static constexpr std::uint32_t kType = 21;
  std::uint8_t action = 0;  ///< 2 full, 3 yaw, 4 mounting reset, 5 pause.
  bool operator==(const UserAction&) const = default;
};
struct FeatureFlags {
  static constexpr std::uint32_t kType = 22;
  std::uint32_t bits = 0;  ///< Of the first four bytes; bit 0 is the lowest of the first byte.
  bool operator==(const FeatureFlags&) const = default;
};
struct RotationAndAcceleration {
  static constexpr std::uint32_t kType = 23;
  std::uint8_t sensor = 0;
  std::array<float, 4> xyzw{};  ///< As Rotation's; 16 bits on the wire.
  std::array<float, 3> m_s2{};  ///< As Acceleration's; within 256, steps of 1/128 on the wire.
  bool operator==(const RotationAndAcceleration&) const = default;
};
struct ConfigAck {
  static constexpr std::uint32_t kType = 24;
  std::uint8_t sensor = 0;
  std::uint16_t what = 0;
  bool operator==(const ConfigAck&) const = default;
};
/// A message of unknown type; skipped.
struct Unknown {
  std::uint32_t type = 0;
  bool operator==(const Unknown&) const = default;
};

using TrackerMessage =
    std::variant<Unknown, Heartbeat, Handshake, Acceleration, Pong, Battery, Tap, SensorError, SensorInfo,
                 Rotation, MagnetometerAccuracy, SignalStrength, Temperature, UserAction, FeatureFlags,
                 RotationAndAcceleration, ConfigAck>;

struct Header {
  std::uint32_t type = 0;
  std::uint64_t number = 0;  ///< Counts a board's packets of all types; 0 on uncounted ones.
};

/// Whether the bytes can be a tracker's datagram: a type below 256 and its least length.
[[nodiscard]] bool is_tracker_datagram(std::span<const std::byte> bytes);

/// One datagram, which holds one message or a bundle of them, appended to `out` in order. The deprecated
/// rotation types 1 and 16 come out as Rotation of sensors 0 and 1. Bytes beyond a message's last known field
/// are skipped, for later firmware. Errors, which leave `out` as it was: truncated; malformed (a bundle
/// inside a bundle or with an empty message, a rotation not of length 1, more than kMaxDatagram bytes);
/// out_of_range (a number not finite, an acceleration above 1000 m/s^2). No allocation but for a handshake's
/// text, when `out` grows, and in errors. Thread-safe.
[[nodiscard]] Result<Header> parse_tracker_datagram(std::span<const std::byte> bytes,
                                                    std::vector<TrackerMessage>& out);

// Tracker messages, for simulated trackers.

/// Appends one datagram. Handshakes and pongs always have the number 0. Errors: bad_usage (an Unknown, a text
/// that is too long).
[[nodiscard]] Result<void> encode_tracker_message(std::uint64_t number, const TrackerMessage& message,
                                                  ByteWriter& out);
/// Appends one datagram of type 100 with all of the messages. Errors: as above, and no message, a handshake
/// or a pong, more than kMaxDatagram bytes.
[[nodiscard]] Result<void> encode_tracker_bundle(std::uint64_t number,
                                                 std::span<const TrackerMessage> messages, ByteWriter& out);

// Server to tracker.

/// Reply to a handshake.
struct Greeting {
  bool operator==(const Greeting&) const = default;
};
struct ServerHeartbeat {
  bool operator==(const ServerHeartbeat&) const = default;
};
struct Ping {
  std::uint32_t id = 0;
  bool operator==(const Ping&) const = default;
};
struct ServerFlags {
  static constexpr std::uint8_t kBundle = 1;  ///< Understands bundles of type 100.
  std::uint8_t bits = 0;
  bool operator==(const ServerFlags&) const = default;
};
/// Reply to a SensorInfo, with its state.
struct SensorInfoAck {
  std::uint8_t sensor = 0;
  std::uint8_t state = 0;
  bool operator==(const SensorInfoAck&) const = default;
};
using ServerMessage = std::variant<Unknown, Greeting, ServerHeartbeat, Ping, ServerFlags, SensorInfoAck>;

/// Appends one datagram; an Unknown appends nothing.
void encode_server_message(const ServerMessage& message, ByteWriter& out);
/// Errors: truncated; malformed (another greeting text).
[[nodiscard]] Result<ServerMessage> parse_server_message(std::span<const std::byte> bytes);

}  // namespace mien::imu::slimevr
