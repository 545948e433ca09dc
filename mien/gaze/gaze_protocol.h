#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "mien/gaze/eyes.h"
#include "mien/gaze/osc_eyes.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sender_places.h"

namespace mien::gaze {

/// OSC names no device. Its senders are "02:4D:49:47:5A:00" and up, counted in the order in which they were
/// first heard; so many at a time.
inline constexpr std::uint64_t kOscDevice = 0x024D'4947'5A00ULL;
inline constexpr std::size_t kMostOscDevices = 16;

/// Host side of gaze: our packet (gaze/packet.h) and what EyeTrackVR and Baballonia send by OSC
/// (gaze/osc_eyes.h), one SampleKind::gaze sample a moment.
///
/// OSC comes coordinate by coordinate, each in a datagram of its own. A sample is made when a coordinate of
/// the round is there that completes what the round before had; one that comes again begins the next round. A
/// coordinate is good for kFresh. Of several dialects the first is believed while it was heard in the last
/// kFresh. OSC carries neither time (it is estimated from arrivals, 10 to 250 rounds a second) nor confidence
/// (a direction that is told counts as sure).
///
/// A program that starts anew comes from another port, and takes its own place again
/// (sensor::TakesPlace::at_once).
class GazeProtocol final : public sensor::Protocol {
 public:
  static constexpr Duration kFresh = std::chrono::milliseconds(500);

  [[nodiscard]] std::string_view name() const override { return "gaze"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  /// OSC without an address of the table is ignored.
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;

 private:
  static constexpr sensor::EstimatedClockSettings kOscClock = {
      .first_period = std::chrono::microseconds(16'667),
      .min_period = std::chrono::milliseconds(4),
      .max_period = std::chrono::milliseconds(100)};
  struct Told {
    float value = 0;
    std::optional<HostTime> at;
    [[nodiscard]] std::optional<float> fresh(HostTime now) const;
  };
  struct OscDevice {
    std::array<std::optional<HostTime>, kDialectCount> dialects{};  // When each told a direction.
    std::array<std::array<Told, 4>, 2> told{};  // Of each eye: yaw, pitch, openness, pupil.
    std::array<std::array<bool, 2>, 2> lost{};  // Of each eye: its yaw, its pitch.
    unsigned seen = 0;      // Directions of this round: bits, yaw and pitch of the left eye, of the right.
    unsigned expected = 0;  // Of the round before.
    bool complete = false;  // This round's sample is made.
    std::uint64_t rounds = 0;
    sensor::EstimatedClock clock{kOscClock};
  };

  static sensor::Verdict take_packet(std::span<const std::byte> packet, sensor::Inbox& inbox);
  sensor::Verdict take_osc(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                           sensor::Inbox& inbox);
  /// Notes what was told; returns the bits of its directions.
  static unsigned note(HostTime arrival, const std::array<SaidOfEye, 2>& said, OscDevice& device);
  static bool completes_round(unsigned told, OscDevice& device);
  static Eyes eyes_at(HostTime arrival, const OscDevice& device);

  sensor::SenderPlaces<sensor::Peer, OscDevice> devices_{kOscDevice, kMostOscDevices,
                                                         sensor::TakesPlace::at_once};
};

}  // namespace mien::gaze
