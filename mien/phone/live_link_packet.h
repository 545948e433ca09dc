#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/livelink_csv.h"
#include "mien/phone/told_face.h"

namespace mien::phone {

/// Longest device id and subject, bytes, as Unreal takes them.
inline constexpr std::size_t kMostLiveLinkName = 255;

/// What Live Link Face, or who speaks as it does, says of one frame: packet version 6. Layout:
/// docs/reference/phones.md.
struct LiveLinkPacket {
  std::string_view device_id;  ///< Of the phone (a UUID), as it stands in the datagram.
  std::string_view subject;    ///< What its user called it; likewise.
  bool timed = false;          ///< Whether it tells its frame; without, there is no face either.
  std::uint32_t frame = 0;     ///< Counts at the rate below, from no known beginning; below 2^31.
  float sub_frame = 0;         ///< Part of a frame, 0 to 1.
  std::uint32_t rate_numerator = 60, rate_denominator = 1;  ///< 1 to 1000 frames a second.
  /// ArkitOrder::live_link_udp, then angles, as in face::LiveLinkRow; within kMostLiveLinkValue. None: the
  /// phone sees no face.
  std::optional<std::array<float, face::kLiveLinkValueCount>> values;

  /// Of the frame, on the phone's clock.
  [[nodiscard]] DeviceTime time() const;
};
/// Weights are 0 to 1 and angles radians; what is beyond this, either way, is neither.
inline constexpr float kMostLiveLinkValue = 100;

/// Whether the bytes begin like a packet of Live Link Face of whatever version; checks no more.
[[nodiscard]] bool is_live_link(std::span<const std::byte> bytes);

/// The version of bytes that begin so, where it is another than the one that is read here.
[[nodiscard]] std::optional<unsigned> unknown_live_link_version(std::span<const std::byte> bytes);

/// Texts of the result stand in `bytes`. Errors: truncated; unsupported (another version, or other than 61
/// values); malformed (a name too long, bytes behind the last value); out_of_range (frame, sub-frame, rate,
/// time as sensor::check_device_time has it, a value). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<LiveLinkPacket> parse_live_link(std::span<const std::byte> bytes);

/// What such values say, sound: weights held to 0 to 1, the head's turn, and nothing of how they came about.
/// Eyes are told by the eyeLook shapes; their angles say the same again.
[[nodiscard]] ToldFace told_face(const std::array<float, face::kLiveLinkValueCount>& values);

}  // namespace mien::phone
