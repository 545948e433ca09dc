#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/core/time.h"

namespace mien::sensor {

/// Which of one sensor's packets have come, by their sequence numbers: up to where nothing is missing. A pure
/// function of the calls. No allocation.
class PacketRun {
 public:
  /// Packets that are remembered: a second of them at 60 Hz.
  static constexpr std::size_t kRemembered = 64;

  /// A sample of a packet. False where that packet came before, or is too far behind to tell.
  bool add(std::uint32_t sequence, DeviceTime time);
  /// Time of the newest sample up to which no packet is missing. Needs a sample.
  [[nodiscard]] DeviceTime whole_until() const { return at(whole_).newest; }
  [[nodiscard]] bool empty() const { return empty_; }
  /// Packets that are missing before the one that has a sample at or after `time` are not waited for any
  /// more; nor are any before the newest where none has.
  void give_up(DeviceTime time);

 private:
  struct Packet {
    std::uint32_t sequence = 0;
    bool came = false;
    DeviceTime newest;  // Of its samples.
  };
  [[nodiscard]] const Packet& at(std::uint32_t sequence) const { return packets_[sequence % kRemembered]; }
  [[nodiscard]] bool came(std::uint32_t sequence) const {
    return at(sequence).came && at(sequence).sequence == sequence;
  }
  void go_on();

  std::array<Packet, kRemembered> packets_{};
  bool empty_ = true;
  std::uint32_t whole_ = 0;  // The last before which none is missing.
  std::uint32_t newest_ = 0;
};

}  // namespace mien::sensor
