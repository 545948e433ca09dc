#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/livelink_csv.h"
#include "mien/phone/told_face.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sender_places.h"

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

/// Phones have no MAC on the wire. They are "02:4D:49:50:48:00" and up, counted in the order in which their
/// ids were first heard; so many at a time.
inline constexpr std::uint64_t kLiveLinkDevice = 0x024D'4950'4800ULL;
inline constexpr std::size_t kMostLiveLinkPhones = 16;

/// Host side of Live Link Face (LiveLinkPacket): samples as WeightsProtocol's. A frame's time is
/// its number at its rate, on the phone's clock, whenever it arrives. A phone is who has its id, whatever it
/// is called and from wherever it sends. A frame without a face says that the phone is there and sees none.
///
/// Samples' sequence counts frames with a face that the phone made: one that films 30 frames a second and
/// counts in sixtieths makes every other one, one of 24 every second or third, so the usual step of the last
/// frames counts as one.
class LiveLinkProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "livelink"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override {
    return is_live_link(datagram);
  }
  [[nodiscard]] std::optional<unsigned> unknown_version(std::span<const std::byte> datagram) const override {
    return unknown_live_link_version(datagram);
  }
  /// Another version's packet is ignored, and so is one more phone than there are places for.
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;

 private:
  static constexpr std::size_t kSteps = 16;
  struct Phone {
    std::optional<std::uint32_t> frame;
    std::uint32_t sequence = 0;
    std::array<std::uint32_t, kSteps> steps{};  // The newest, of those forwards; 0: not yet.
    std::size_t next_step = 0;
  };
  /// Goes to this frame. One without a face is not missed where the next has one.
  static void count(std::uint32_t frame, bool face, Phone& phone);
  /// How many numbers a frame takes; 0 while unknown.
  static double usual_step(const Phone& phone);

  sensor::SenderPlaces<std::string, Phone> phones_{kLiveLinkDevice, kMostLiveLinkPhones,
                                                   sensor::TakesPlace::when_full};
};

}  // namespace mien::phone
