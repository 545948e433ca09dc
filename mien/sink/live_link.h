#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "mien/face/livelink_csv.h"
#include "mien/sink/arkit_frame.h"
#include "mien/sink/datagrams.h"

namespace mien::sink {

/// Unreal's Live Link Face listens here unless told otherwise.
inline constexpr std::uint16_t kLiveLinkPort = 11111;
/// Longest device id and subject name, bytes: receivers refuse longer packets than these make.
inline constexpr std::size_t kMaxLiveLinkName = 255;

/// Who a receiver takes the packets to be from; it keys its subjects by both.
struct LiveLinkSource {
  std::string device_id;  ///< A UUID, 36 characters.
  std::string subject;    ///< What Unreal lists: "mien". UTF-8, at most kMaxLiveLinkName bytes.
};

/// The source of that subject: its device id is made from the name (a UUID of version 8), so that a session
/// which is begun again is the same device to its receivers.
[[nodiscard]] LiveLinkSource live_link_source(std::string_view subject);

/// What Live Link Face says of one frame: ARKit's 52 in face::ArkitOrder::live_link_udp, then HeadYaw,
/// HeadPitch, HeadRoll, LeftEyeYaw, LeftEyePitch, LeftEyeRoll and the right eye's, radians. Eyes: yaw
/// positive to the performer's right, pitch positive down, roll 0 (measured on a capture). Head:
/// the same signs, and roll positive to the right shoulder, are UNVERIFIED; they are those of
/// face::livelink_from_head.
[[nodiscard]] std::array<float, face::kLiveLinkValueCount> live_link_values(const ArkitFrame& frame);

/// What one packet says of its frame.
struct LiveLinkFrame {
  std::int64_t number = 0;    ///< Counts from wherever the sender began; its lowest 31 bits are sent.
  std::int32_t rate_hz = 60;  ///< At which numbers count.
  /// live_link_values(), or what a phone tells in their place. None: it sees no face.
  std::optional<std::array<float, face::kLiveLinkValueCount>> values;
};

/// One Live Link Face datagram, packet version 6: a header, then the values, highest byte first; without a
/// face it ends behind its rate. The sub-frame is 0. Allocates only while `out` grows. Layout:
/// docs/reference/sinks.md.
void encode_live_link(const LiveLinkFrame& frame, const LiveLinkSource& source, Datagrams& out);

/// The same of a frame of the grid, whose index becomes the number, at 60 a second.
void encode_live_link(const ArkitFrame& frame, const LiveLinkSource& source, std::int64_t frame_index,
                      Datagrams& out);

}  // namespace mien::sink
