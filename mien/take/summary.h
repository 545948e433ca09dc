#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/take/take.h"

namespace mien::take {

/// How well one sensor was heard, from its samples, in whatever order they came. A gap is a step of more than
/// one and a half sample periods; what it should have held counts as lost. Of a face that another program
/// told a gap is one of its packets' numbers, where these stand in them: one that sees no face sends none.
/// Where the device's clock leapt nothing is missing.
struct SensorSummary {
  std::string name;
  std::string role;         ///< As in the rig: "face", "truth", ...
  std::size_t samples = 0;  ///< A face that came in parts is one.
  std::size_t doubled = 0;  ///< Samples with a time that another had; not counted again elsewhere.
  double rate_hz = 0;       ///< One over the median step; 0 with fewer than two samples.
  double begin_s = 0;       ///< First and last sample, the sensor's own clock.
  double end_s = 0;
  std::size_t lost = 0;
  double loss = 0;  ///< lost / (lost + heard), 0 to 1.
  std::size_t gaps = 0;
  double longest_gap_s = 0;     ///< 0 without gaps.
  std::size_t leaps = 0;        ///< Times that its clock went on elsewhere: begun anew, or set.
  double heard_s = 0;           ///< From the first to the last sample, without leaps.
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

/// When one sample was taken, and when and under which number it came.
struct SampleTime {
  DeviceTime time;
  HostTime arrival;
  std::uint32_t sequence = 0;
};

/// One sensor, from its samples in the order in which they came. `numbered`: each has a number of its own.
[[nodiscard]] SensorSummary summarise_sensor(std::string name, std::span<const SampleTime> samples,
                                             bool numbered);

}  // namespace mien::take
