#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_simulator.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/network.h"

namespace mien::virt {

/// A virtual wearer's glasses as the boards that carry their sensors: scan after scan of the simulator in the
/// packets of docs/reference/protocol.md. The rig's bindings say which sensor is which board's channel. The
/// same stream gives the same packets, however they are asked for. Not thread-safe.
class EyewearBoards {
 public:
  /// The glasses are put on: the seat is drawn. The wearer must outlive this. Errors: bad_usage (a sensor
  /// without a device; a board whose channels are not 0, 1, 2, ...; more than kMaxChannels).
  [[nodiscard]] static Result<EyewearBoards> put_on(const EyewearWearer& wearer, const sensor::Rig& rig,
                                                    const EyewearFaults& faults, const Random& random);

  [[nodiscard]] std::size_t count() const { return boards_.size(); }
  /// The id of each, below count().
  [[nodiscard]] std::uint64_t device(std::size_t board) const { return boards_[board].device; }
  [[nodiscard]] const VirtualClock& clock() const { return simulator_.clock(); }
  /// True time up to which everything has been scanned, s from the performance's time 0.
  [[nodiscard]] double scanned_s() const { return scanned_s_; }

  /// The next few scans, a sixtieth of a second or so, of a face that has these weights at a true time (s):
  /// what each board sends, and when it is heard. Errors: the packet's encoder's. Cost: about a millisecond.
  Result<void> scan(const std::function<face::BlendshapeWeights(double)>& weights_at,
                    std::vector<Datagram>& sent);

 private:
  struct Board {
    std::uint64_t device = 0;
    std::vector<std::uint16_t> sensors;  // Of each channel, its number in the rig.
  };
  EyewearBoards(const EyewearWearer& wearer, const EyewearFaults& faults, const Random& random,
                std::vector<Board> boards, std::size_t sensors);

  EyewearSimulator simulator_;
  std::uint8_t adc_bits_ = 10;
  std::vector<Board> boards_;
  std::size_t sensors_ = 0;
  double scanned_s_ = 0;
};

}  // namespace mien::virt
