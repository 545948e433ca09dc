#pragma once

#include <cstdint>
#include <vector>

#include "mien/eyewear/packet.h"
#include "mien/eyewear/text_line.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"

namespace mien::eyewear {

/// Text lines carry no device name. Their devices are "02:4D:49:54:58:00" and up, counted in the order in
/// which they were accepted; so many at a time.
inline constexpr std::uint64_t kTextDevice = 0x024D'4954'5800ULL;
inline constexpr std::size_t kMaxTextDevices = 16;

struct EyewearProtocolSettings {
  /// Resolution of the converter, bits, kMinAdcBits to kMaxAdcBits, for text lines without a header that
  /// gives it (10: Arduino Uno). Raising by one halves the light that a step stands for, lowering by one
  /// doubles it. Above the converter's own, saturation is never reported; below it, lines with values beyond
  /// the range are malformed.
  std::uint8_t text_bits = 10;
};

/// Host side of the eyewear protocols: packets (eyewear/packet.h), plain or as COBS frames, and text lines
/// (eyewear/text_line.h). Every channel is a device, "id/channel", with one eyewear_light sample a scan,
/// saturated at the upper end of the converter's range.
///
/// A text device is accepted after eight successive lines with the same number of values, since the first may
/// be partial. Then a line with another number is malformed; after half a second without a right one, eight
/// successive lines with another number are accepted. A header restarts this. Lines carry no time: it is
/// estimated from arrivals, one clock for all sensors of a line, at 10 to 1000 lines a second. A sample's
/// sequence counts the accepted lines.
///
/// Who sends a few lines takes nobody's place: of 512 peers that are not accepted yet one that was silent for
/// a second, or else the one with the shortest run of lines, and of these the one silent longest, is
/// forgotten for the next. When all 16 devices are there, the one without an accepted line for longest, ten
/// seconds at least, gives its place to the next, which has an id of its own; of the last 16 each gets its
/// own again.
class EyewearProtocol final : public sensor::Protocol {
 public:
  /// Errors: bad_usage (bits).
  [[nodiscard]] static Result<EyewearProtocol> create(EyewearProtocolSettings settings = {});

  [[nodiscard]] std::string_view name() const override { return "eyewear"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;

 private:
  static constexpr std::size_t kMaxTextCandidates = 512;
  /// Successive lines with the same number of values.
  struct Run {
    std::size_t values = 0;
    int lines = 0;
    /// Whether so many agree that the number is accepted.
    bool add(std::size_t its_values);
  };
  /// A peer that sends text, and is not accepted yet.
  struct TextCandidate {
    sensor::Peer peer = 0;
    TextHeader header;
    Run run;
    HostTime received;  // Arrival of the newest line.
  };
  struct TextDevice {
    sensor::Peer peer = 0;
    std::uint64_t id = 0;
    TextHeader header;
    std::size_t columns = 0;  // Values of a line; 0 after a header, until accepted again.
    HostTime accepted;        // Arrival of the newest such line.
    Run other;                // Lines with another number.
    std::uint64_t lines = 0;
    sensor::EstimatedClock clock;
  };

  explicit EyewearProtocol(EyewearProtocolSettings settings);
  static sensor::Verdict take_packet(std::span<const std::byte> packet, sensor::Inbox& inbox);
  sensor::Verdict take_line(HostTime arrival, sensor::Peer peer, std::span<const std::byte> line,
                            sensor::Inbox& inbox);
  sensor::Verdict take_line_of_candidate(HostTime arrival, sensor::Peer peer, const TextLine& line,
                                         sensor::Inbox& inbox);
  sensor::Verdict take_values(HostTime arrival, TextDevice& device, const TextValues& line,
                              sensor::Inbox& inbox) const;
  /// Whether a line of this device has values in pairs, if they come so, none too many, all within range.
  [[nodiscard]] bool is_sound(const TextValues& line, const TextHeader& header) const;
  /// The candidate of this peer, from now on if it is new.
  TextCandidate& meet(sensor::Peer peer, HostTime arrival);
  /// The device that a candidate becomes; null: all are there.
  TextDevice* accept(HostTime arrival, const TextCandidate& candidate);
  [[nodiscard]] std::int32_t full_scale(const TextHeader& header) const;

  EyewearProtocolSettings settings_;
  std::vector<TextCandidate> candidates_;
  std::vector<TextDevice> devices_;
  struct Id {
    sensor::Peer peer = 0;
    std::uint64_t device = 0;
  };
  std::vector<Id> former_;          // Of devices that gave their place to others, the newest last.
  std::uint64_t text_devices_ = 0;  // So far.
};

}  // namespace mien::eyewear
