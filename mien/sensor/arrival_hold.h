#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "mien/core/time.h"

namespace mien::sensor {

/// By how much frames are held back for packets that come late: 0 while arrivals are punctual, however many
/// packets are lost and however long all of them take.
///
/// A packet's lateness is counted beyond what its sensor's clock model expects. A sensor votes for a hold
/// while a fifth of its packets of the last second are late, in three of that second's five windows at least:
/// one stall is none. Only where two vote is there a hold, so that no single sensor and no forged clock makes
/// one: the second largest of the voters' 95 % quantiles, kMost at most. It rises with the window that asks
/// for more and falls by 5 ms a second. A pure function of the calls, in the order of arrival. No allocation
/// after the constructor. Cost: O(1), and O(sensors) five times a second.
class ArrivalHold {
 public:
  static constexpr Duration kMost = std::chrono::milliseconds(60);

  explicit ArrivalHold(std::size_t sensors) : sensors_(sensors) {}

  /// A sample as it arrives, and how much later than its clock model expects it at the earliest. Of a
  /// packet's samples the least late counts: it is the one that was waited for.
  void add(std::uint16_t sensor, std::uint32_t sequence, HostTime arrival, Duration late);
  /// The sensor's next samples are another board's.
  void forget(std::uint16_t sensor) { sensors_[sensor] = {}; }

  /// 0 to kMost; the longest is that since the constructor.
  [[nodiscard]] Duration now() const { return now_; }
  [[nodiscard]] Duration longest() const { return longest_; }

 private:
  static constexpr std::size_t kWindows = 5;
  /// Lateness in steps of 4 ms; the last bin has all beyond kMost.
  static constexpr std::size_t kBins = 16;

  struct Window {
    std::array<std::uint32_t, kBins> packets{};
    std::uint32_t all = 0;
    std::uint32_t late = 0;
  };
  struct Packet {
    std::uint32_t sequence = 0;
    HostTime arrival;
    Duration late{};
  };
  struct Sensor {
    std::optional<Packet> packet;  // Whose samples are being added.
    std::array<Window, kWindows> windows{};
  };

  static void count(const Packet& packet, Window& window);
  /// What the sensor votes for; none where it does not.
  [[nodiscard]] static std::optional<Duration> vote(const Sensor& sensor);
  void close_window();

  std::vector<Sensor> sensors_;
  std::int64_t window_ = 0;  // Of host time.
  bool begun_ = false;
  Duration now_{};
  Duration longest_{};
};

}  // namespace mien::sensor
