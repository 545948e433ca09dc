#pragma once

#include <cstdint>
#include <vector>

#include "mien/eyewear/packet.h"
#include "mien/eyewear/text_line.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"

namespace mien::eyewear {

/// Text lines carry no name. Their devices are "02:4D:49:54:58:00" and on: the last octet counts the places
/// that lines come from, in the order in which they first spoke.
inline constexpr std::uint64_t kTextDevice = 0x024D'4954'5800ULL;
inline constexpr std::size_t kMaxTextDevices = 16;

struct EyewearProtocolSettings {
  /// The converter behind text lines whose header does not say it, kMinAdcBits to kMaxAdcBits.
  std::uint8_t text_bits = 10;
};

/// The host's side of smart eyewear: our packets (eyewear/packet.h), as they are or as COBS frames, and plain
/// text lines (eyewear/text_line.h). Every channel is a device of its own, "id/channel", and gives one
/// photo_reflective sample a scan; it is saturated at the upper end of the converter's range.
///
/// Of a text device nothing is believed before eight lines in a row have one number of values: the first may
/// be half a line. From then on a line with another number is malformed; but when none with the right one
/// came for half a second, eight others in a row are believed. A header begins anew. Lines carry no time: it
/// is estimated from the arrivals, for all sensors of a line alike, from 10 to 1000 lines a second. A
/// sample's sequence counts the lines that were understood.
class EyewearProtocol final : public sensor::Protocol {
 public:
  /// Errors: bad_usage (bits).
  [[nodiscard]] static Result<EyewearProtocol> create(EyewearProtocolSettings settings = {});

  [[nodiscard]] std::string_view name() const override { return "eyewear"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
  /// Nothing: eyewear only speaks.
  void heartbeats(HostTime, std::vector<Outgoing>&) override {}

 private:
  struct TextDevice {
    sensor::Peer peer = 0;
    std::uint64_t id = 0;
    TextHeader header;
    std::size_t columns = 0;    // Values of a line; 0 until they are believed.
    HostTime believed;          // The newest line of so many.
    std::size_t candidate = 0;  // Values of the newest lines while none is believed,
    int agreed = 0;             // and how many such lines there were in a row.
    std::uint64_t lines = 0;
    sensor::EstimatedClock clock;
  };

  explicit EyewearProtocol(EyewearProtocolSettings settings);
  static sensor::Verdict take_packet(std::span<const std::byte> packet, sensor::Inbox& inbox);
  sensor::Verdict take_line(HostTime arrival, sensor::Peer peer, std::span<const std::byte> line,
                            sensor::Inbox& inbox);
  sensor::Verdict take_values(HostTime arrival, TextDevice& device, const TextValues& line,
                              sensor::Inbox& inbox) const;
  TextDevice* device_of(sensor::Peer peer);
  [[nodiscard]] std::uint8_t bits_of(const TextDevice& device) const;

  EyewearProtocolSettings settings_;
  std::vector<TextDevice> devices_;
};

}  // namespace mien::eyewear
