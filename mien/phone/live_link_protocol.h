#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "mien/phone/live_link_packet.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sender_places.h"

namespace mien::phone {

/// Phones have no MAC on the wire. They are "02:4D:49:50:48:00" and up, counted in the order in which their
/// ids were first heard; so many at a time.
inline constexpr std::uint64_t kLiveLinkDevice = 0x024D'4950'4800ULL;
inline constexpr std::size_t kMostLiveLinkPhones = 16;

/// Host side of Live Link Face (phone/live_link_packet.h): samples as WeightsProtocol's. A frame's time is
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
