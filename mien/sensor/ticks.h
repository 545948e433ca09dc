#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mien/sensor/arrival_hold.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/packet_run.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"

namespace mien::sensor {

/// One frame of the output grid that is due.
struct FrameTick {
  std::int64_t index = 0;  ///< Of the grid: frame == frame_offset(index) on the reference's line.
  DeviceTime frame;        ///< On the reference's line.
  HostTime fired;          ///< Arrival that completed it, or the deadline that it did not wait beyond; never
                           ///< before the newest arrival that it knows of.
  bool complete = false;   ///< Every sensor received lately had a sample at or after the frame, and while
                           ///< frames are held no packet of it was missing before.
  bool operator==(const FrameTick&) const = default;
};

/// When frames are taken: the frames of a 60 Hz grid on the reference sensor's device time. One fires when
/// every sensor received in the last 100 ms has a sample at or after its frame time, or 8 ms after the clock
/// model expected the reference's; what comes later joins the next. While packets come late (ArrivalHold) it
/// fires by as much later, or as soon as every sensor's packets up to its time are there. While the reference
/// is silent the grid runs on along its clock as last known, and when it never sent, along the host's. Truths
/// are followed by clocks of their own, and frames are the same without them. A pure function of the calls.
///
/// For each log entry: fire all that due(arrival) gives, then add its samples, then fire all that
/// due(arrival) gives. Between entries: due(now) when deadline() has passed.
class TickRule {
 public:
  static constexpr Duration kFresh = std::chrono::milliseconds(100);
  static constexpr Duration kWait = std::chrono::milliseconds(8);
  /// By so much of the line may frames run ahead of the host time at which they fire, and then come no faster
  /// than that goes (kFaster): a clock that leaps ahead leaves frames out instead of a backlog.
  static constexpr Duration kMostAhead = std::chrono::seconds(1);
  /// Share by which the line may run ahead of host time: far more than any crystal.
  static constexpr double kFaster = 0.02;

  explicit TickRule(const Rig& rig);

  void add(HostTime arrival, const Sample& sample);
  /// As TimeLines::pulse.
  void pulse(std::uint16_t sensor, std::uint32_t index, DeviceTime edge) {
    lines_.pulse(sensor, index, edge);
  }
  /// As TimeLines::forget; frames do not wait for the board that was there.
  void forget(std::uint16_t sensor);
  /// The next frame that is due, in order; ask until there is none. `now` never runs back.
  [[nodiscard]] std::optional<FrameTick> due(HostTime now);
  /// When the next frame fires if nothing more arrives; none before the line is known.
  [[nodiscard]] std::optional<HostTime> deadline() const;
  [[nodiscard]] const TimeLines& lines() const { return lines_; }
  /// By how much frames are held back.
  [[nodiscard]] const ArrivalHold& hold() const { return hold_; }

 private:
  struct Received {
    HostTime arrival;
    DeviceTime newest;
    bool ever = false;
    bool waited_for = true;  // False of a truth.
    PacketRun packets;       // Empty where times are estimated from arrivals, or on the line already.
  };
  void watch_arrival(HostTime arrival, const Sample& sample);
  [[nodiscard]] bool all_have(DeviceTime frame, HostTime now) const;
  void begin();
  void follow_reference(const Sample& sample);
  void refill(HostTime fired);

  TimeLines lines_;
  ArrivalHold hold_;
  std::optional<std::uint16_t> reference_;
  std::vector<Received> received_;
  HostTime newest_arrival_ = HostTime::min();
  std::optional<std::int64_t> next_;
  Duration credit_ = kMostAhead;  // How much of the line frames may go on by.
  std::optional<HostTime> refilled_;
  // The reference sends samples in packets; a sample in the middle of one comes with its end.
  std::optional<std::uint32_t> packet_;
  DeviceTime packet_end_;
  std::optional<DeviceTime> previous_end_;
  Duration packet_period_{};  // 0 while unknown.
};

}  // namespace mien::sensor
