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

/// Marker tracks from the marker packets of a session's log. Positions received before their names are kept
/// until these arrive. Doubled or late packets are ignored; where the server's clock goes back by more than a
/// second, the server restarted and a new track begins. A pure function of the calls.
class MarkerLog {
 public:
  /// One list of markers of one server, between two of its starts.
  struct Received {
    std::uint64_t device = 0;
    MarkerTrack track;              ///< Times by the server's clock; named "markers".
    std::vector<HostTime> arrival;  ///< Of each frame.
  };

  /// A datagram of the log; others than marker packets are ignored.
  void add(HostTime arrival, std::span<const std::byte> datagram);
  /// All tracks with complete names, the one with the most frames first.
  [[nodiscard]] std::vector<Received> received() const;
  /// Number of frames without complete names.
  [[nodiscard]] std::size_t unnamed() const;

 private:
  /// Frames of one server between two starts of it.
  struct Run {
    std::vector<double> time_s;
    std::vector<Vec3f> position_m;
    std::vector<HostTime> arrival;
  };
  struct List {
    std::vector<std::string> names;  // Empty where not received yet.
    std::size_t count = 0;           // Markers of a frame; 0 before the first.
    Run run;
    [[nodiscard]] bool named() const;
  };
  using Key = std::pair<std::uint64_t, std::uint32_t>;  // Device and list.
  std::map<Key, List> lists_;
  std::vector<std::pair<Key, Run>> ended_;
};

}  // namespace mien::mocap
