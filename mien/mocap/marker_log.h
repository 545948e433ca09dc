#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/time.h"
#include "mien/mocap/marker_packet.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// Markers out of a session's log: what servers sent, packet by packet, as tracks. Positions that came before
/// their names wait for them. Packets that are doubled or came late are passed over; where the server's clock
/// goes back by more than a second it was started anew, and another track begins. A pure function of what
/// is added.
class MarkerLog {
 public:
  /// One list of markers of one server, from one start of it.
  struct Received {
    std::uint64_t device = 0;
    MarkerTrack track;              ///< Times by the server's clock; named "markers".
    std::vector<HostTime> arrival;  ///< Of each frame.
  };

  /// A datagram of the log; one that is no marker packet changes nothing.
  void add(HostTime arrival, std::span<const std::byte> datagram);
  /// All whose names are known whole, the one with the most frames first. Others have not been named.
  [[nodiscard]] std::vector<Received> received() const;
  /// Frames whose markers nobody named.
  [[nodiscard]] std::size_t unnamed() const;

 private:
  /// Frames of one server between two starts of it.
  struct Run {
    std::vector<double> time_s;
    std::vector<Vec3f> position_m;
    std::vector<HostTime> arrival;
  };
  struct List {
    std::vector<std::string> names;  // Empty where not told yet.
    std::size_t count = 0;           // Markers of a frame; 0 before the first.
    Run run;
    [[nodiscard]] bool named() const;
  };
  using Key = std::pair<std::uint64_t, std::uint32_t>;  // Device and list.
  std::map<Key, List> lists_;
  std::vector<std::pair<Key, Run>> ended_;
};

}  // namespace mien::mocap
