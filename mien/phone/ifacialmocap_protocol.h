#pragma once

#include <cstdint>

#include "mien/phone/ifacialmocap_frame.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sender_places.h"

namespace mien::phone {

/// iFacialMocap names no phone. Its senders are "02:4D:49:46:4D:00" and up, counted in the order in which
/// they were first heard; so many at a time.
inline constexpr std::uint64_t kIFacialMocapDevice = 0x024D'4946'4D00ULL;
inline constexpr std::size_t kMostIFacialMocapPhones = 16;

/// Host side of iFacialMocap (phone/ifacialmocap_frame.h): samples as WeightsProtocol's. Frames carry neither
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
