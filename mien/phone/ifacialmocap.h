#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mien/core/error.h"
#include "mien/phone/told_face.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sender_places.h"

namespace mien::phone {

/// Longest frame that is read, bytes: twice what phones send.
inline constexpr std::size_t kMostIFacialMocapBytes = 2048;

/// What iFacialMocap, or who speaks as it does, says of one moment. Layout: docs/reference/phones.md.
struct IFacialMocapFrame {
  bool tracked = true;  ///< False: the phone says that it sees no face.
  ToldFace face;        ///< In ARKit's 52; sound; what was not told is kUntold.
};

/// Whether the bytes begin like a frame: a name, then `&` or `-` and a number, or `=head#`; checks no more.
[[nodiscard]] bool is_ifacialmocap(std::span<const std::byte> bytes);

/// Either version: `-` before a number is the first's, `&` the second's, and both may have decimals. Weights
/// are percent and held to 0 to 1; what names none of ARKit's is passed over, of one that stands there
/// twice the last counts. The head's turn is of degrees about X, Y, Z as sink::encode_ifacialmocap sends it,
/// its position m; where that is 0, 0, 0 it is not known. Eyes are told by the eyeLook shapes. Errors:
/// out_of_range (longer than kMostIFacialMocapBytes; a number that is not finite or beyond its range);
/// malformed (a head of other than six numbers; nothing told). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<IFacialMocapFrame> parse_ifacialmocap(std::span<const std::byte> bytes);

/// iFacialMocap names no phone. Its senders are "02:4D:49:46:4D:00" and up, counted in the order in which
/// they were first heard; so many at a time.
inline constexpr std::uint64_t kIFacialMocapDevice = 0x024D'4946'4D00ULL;
inline constexpr std::size_t kMostIFacialMocapPhones = 16;

/// Host side of iFacialMocap (IFacialMocapFrame): samples as WeightsProtocol's. Frames carry neither
/// time nor number: both are of their arrivals, 10 to 120 frames a second. A frame whose phone sees no face
/// says so.
class IFacialMocapProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "ifacialmocap"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override {
    return is_ifacialmocap(datagram);
  }
  /// One more phone than there are places for is ignored.
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;

 private:
  struct Phone {
    std::uint64_t frames = 0;
    sensor::EstimatedClock clock{{.first_period = std::chrono::microseconds(16'667),
                                  .min_period = std::chrono::milliseconds(8),
                                  .max_period = std::chrono::milliseconds(100)}};
  };
  sensor::SenderPlaces<sensor::Peer, Phone> phones_{kIFacialMocapDevice, kMostIFacialMocapPhones,
                                                    sensor::TakesPlace::at_once};
};

}  // namespace mien::phone
