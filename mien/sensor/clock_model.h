#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "mien/core/time.h"
#include "mien/sensor/sample.h"

namespace mien::sensor {

struct ClockSettings {
  /// The earliest arrival of each stretch of this length is kept, 60 of them. Raising survives worse radio,
  /// follows drift later; lowering follows drift sooner, by fewer arrivals a stretch.
  Duration stretch = std::chrono::seconds(1);
  /// The fitted rate is held within plus and minus this, a share (1e-6 is 1 ppm): what is beyond is noise,
  /// not a crystal. Raising accepts worse crystals, and more of the radio's noise in a young fit; lowering
  /// rejects more noise, and lets a crystal beyond it drift away from its line.
  double max_rate = 100e-6;
  /// Until the kept arrivals span this much device time the rate is taken as 0: a fit would see the radio's
  /// noise. Raising: less of that noise in the first fitted rate; drift is followed later. Lowering: sooner,
  /// and noisier.
  Duration min_span = std::chrono::seconds(8);
};

/// Where one device's clock stands against the host's: host = device + offset + rate * device, fitted as the
/// line that lies under all (device time, arrival) pairs and closest to them. Radio and operating system only
/// ever delay, so the earliest arrivals carry the clock, and delays cancel out. The constant least delay
/// stays in the offset; between devices of one kind it cancels. A pure function of the pairs pushed. No
/// allocation. Cost: adding O(1), asking after a change O(stretches). Source: Moon, Skelly and Towsley 1999,
/// "Estimation and removal of clock skew from network delay measurements", doi:10.1109/INFCOM.1999.749287.
class ClockModel {
 public:
  explicit ClockModel(const ClockSettings& settings = {}) : settings_(settings) {}

  /// A packet's newest device time and its arrival. Returns true when the device's clock has jumped (a
  /// restart of the board) and the fit began anew from this pair.
  bool add(DeviceTime device, HostTime arrival);
  /// The next pair is another clock's, however near to this one's: it counts as a jump.
  void expect_jump() { jump_expected_ = pairs_ > 0; }

  /// False before the first pair; then the conversions below mean nothing.
  [[nodiscard]] bool ready() const { return pairs_ > 0; }
  /// When a sample of this time arrives at the earliest.
  [[nodiscard]] HostTime to_host(DeviceTime device) const;
  [[nodiscard]] DeviceTime to_device(HostTime host) const;
  /// The line before the latest jump: what the old clock would have read.
  [[nodiscard]] DeviceTime to_device_before_jump(HostTime host) const;
  /// The device's rate against the host's, as a share: 20e-6 is a clock that loses 20 us a second.
  [[nodiscard]] double rate() const;
  /// Standard deviation of to_host at that time, about: how far earliest arrivals scatter, and what the rate
  /// may add.
  [[nodiscard]] Duration uncertainty(DeviceTime device) const;

 private:
  struct Point {
    double x = 0;  // Device time, s since the base.
    double y = 0;  // Arrival less device time, s less the base's.
  };
  struct Line {
    std::int64_t base_device_ns = 0;
    std::int64_t base_offset_ns = 0;
    double offset_s = 0;
    double rate = 0;
    [[nodiscard]] DeviceTime to_device(HostTime host) const;
  };
  static constexpr std::size_t kStretches = 60;

  void restart(DeviceTime device, HostTime arrival);
  void fit() const;
  [[nodiscard]] const Point& point(std::size_t i) const { return earliest_[(first_ + i) % kStretches]; }

  ClockSettings settings_;
  std::array<Point, kStretches> earliest_;  // One a stretch, a ring.
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::int64_t stretch_index_ = 0;
  std::int64_t pairs_ = 0;
  double newest_x_ = 0;
  double delay_sum_ = 0;  // Of y over the pairs, for the uncertainty of a young fit.
  std::optional<HostTime> late_since_;
  bool jump_expected_ = false;
  Line before_jump_;
  // The fit is made when it is asked for: many pairs change nothing.
  mutable bool fitted_ = false;
  mutable Line line_;
  mutable double scatter_s_ = 0;
};

/// The reference's time line and every sensor's way to it. The line is the reference sensor's device time.
/// When nothing is received from the reference in the first half second, or the samples are of the lab
/// profile (which stand on the line already), it is the host's time instead, and stays so for the whole
/// session. A reference that restarts is joined on where it left off, so that the line never runs back.
class TimeLines {
 public:
  /// `reference` is a number below `sensor_count`, or none.
  TimeLines(std::size_t sensor_count, std::optional<std::uint16_t> reference);

  /// A sample as it arrives; samples of unknown sensors are ignored.
  void add(HostTime arrival, const Sample& sample);
  /// The same of a sensor that the line is nothing to: its clock is followed, and neither begins nor decides
  /// the line. Whether its clock jumped.
  bool follow(HostTime arrival, const Sample& sample);
  /// The edge of a pulse on a wire that all nodes share, each on its own clock. From the second pulse that a
  /// sensor and the reference have in common, that sensor's way to the line is by pulses, and the radio's
  /// delays play no part in it.
  void pulse(std::uint16_t sensor, std::uint32_t index, DeviceTime edge);

  /// The sensor's next samples are another board's, with another clock. Where the reference's carries the
  /// line, the new one is joined on where the old one would stand, as after a restart.
  void forget(std::uint16_t sensor);

  /// True once the line is decided; the conversions below need it.
  [[nodiscard]] bool ready() const { return basis_ != Basis::open; }
  [[nodiscard]] bool on_host_time() const { return basis_ == Basis::host; }
  [[nodiscard]] bool has_samples(std::uint16_t sensor) const;
  /// One sensor's device time on the line, and back. The sensor has samples.
  [[nodiscard]] DeviceTime to_line(std::uint16_t sensor, DeviceTime device) const;
  [[nodiscard]] DeviceTime from_line(std::uint16_t sensor, DeviceTime line) const;
  /// When a reference sample of this time arrives at the earliest.
  [[nodiscard]] HostTime to_host(DeviceTime line) const;
  [[nodiscard]] DeviceTime from_host(HostTime host) const;
  [[nodiscard]] const ClockModel& clock(std::uint16_t sensor) const { return clocks_[sensor].model; }

 private:
  enum class Basis : std::uint8_t { open, reference, host };
  struct Pulse {
    std::uint32_t index = 0;
    DeviceTime edge;
  };
  static constexpr std::size_t kPulses = 8;  // A pulse may be told of this many later.
  static constexpr Duration kPulseHolds = std::chrono::seconds(10);  // Then the cable is out.
  struct Clock {
    ClockModel model;
    bool on_line = false;  // The lab profile's times stand on the line already.
    std::array<std::optional<Pulse>, kPulses> pulses;
    ClockModel wire;  // From its time to the reference's, by pulses; nothing delays these.
    int pairs = 0;
    DeviceTime last_edge;  // Of the newest pair.
    DeviceTime newest;     // Of its samples.
  };
  [[nodiscard]] bool by_wire(const Clock& clock) const {
    return basis_ == Basis::reference && clock.pairs >= 2 && clock.newest - clock.last_edge < kPulseHolds;
  }
  void pair(Clock& clock, const Pulse& own, const Pulse& reference);
  std::vector<Clock> clocks_;
  std::optional<std::uint16_t> reference_;
  Basis basis_ = Basis::open;
  std::optional<HostTime> begin_;
  Duration shift_{};  // Line less the reference's device time; changes when it restarts.
};

}  // namespace mien::sensor
