#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/take/take.h"

namespace mien::take {

/// How well one sensor was heard, from the device times of its samples, in whatever order they came. A gap is
/// a step of more than one and a half sample periods; what it should have held counts as lost.
struct SensorSummary {
  std::string name;
  std::size_t samples = 0;
  std::size_t doubled = 0;  ///< Samples with a time that another had; not counted again elsewhere.
  double rate_hz = 0;       ///< One over the median step; 0 with fewer than two samples.
  double begin_s = 0;       ///< First and last sample, the sensor's own clock.
  double end_s = 0;
  std::size_t lost = 0;
  double loss = 0;  ///< lost / (lost + heard), 0 to 1.
  std::size_t gaps = 0;
  double longest_gap_s = 0;     ///< 0 without gaps.
  bool time_estimated = false;  ///< Some of its times were.
};

/// A take at a glance: `mien take info`.
struct Summary {
  /// The first frame's time, on the reference's clock: where the take's own time begins. A live device's
  /// clock counts from its power-on.
  DeviceTime begin;
  double duration_s = 0;  ///< Longest span of any track: log, ticks, truth, sound, a sensor's samples.
  std::size_t entries = 0;
  std::size_t entry_bytes = 0;  ///< Without their payloads.
  std::size_t payloads = 0;
  std::size_t payload_bytes = 0;
  std::size_t ticks = 0;
  std::size_t samples = 0;
  std::vector<SensorSummary> sensors;  ///< In the rig's order.
  std::size_t truth_frames = 0;
  std::size_t truth_lost = 0;       ///< Frames without a face.
  std::size_t truth_evaluated = 0;  ///< With a face, outside the prologue.
  double audio_s = 0;
  int audio_rate_hz = 0;
};

/// Reads every track. Errors: as the tracks' readers.
[[nodiscard]] Result<Summary> summarise(const Take& take);

/// Events that say the same: of one kind, with the same details.
struct EventGroup {
  Event first;  ///< The earliest to begin.
  std::size_t count = 1;
  DeviceTime end;  ///< Of the latest to end.
};

/// Groups in the order in which their first begins; live sessions have hundreds of sensors lost and back.
[[nodiscard]] std::vector<EventGroup> group_events(std::span<const Event> events);

/// One sensor, from the times of its samples in any order.
[[nodiscard]] SensorSummary summarise_sensor(std::string name, std::vector<DeviceTime> times);

}  // namespace mien::take
