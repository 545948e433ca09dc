#include "mien/take/summary.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "mien/core/median.h"

namespace mien::take {
namespace {

constexpr double kGapPeriods = 1.5;

template <class Items, class Time>
double span_s(const Items& items, Time time) {
  return items.empty() ? 0 : to_seconds(time(items.back()) - time(items.front()));
}

}  // namespace

SensorSummary summarise_sensor(std::string name, std::vector<DeviceTime> times) {
  SensorSummary summary;
  summary.name = std::move(name);
  summary.samples = times.size();
  if (times.empty()) return summary;
  std::ranges::sort(times);
  const auto doubled = std::ranges::unique(times);
  summary.doubled = doubled.size();
  times.erase(doubled.begin(), doubled.end());
  summary.begin_s = to_seconds(times.front().time_since_epoch());
  summary.end_s = to_seconds(times.back().time_since_epoch());
  if (times.size() < 2) return summary;

  std::vector<double> steps_s;
  steps_s.reserve(times.size() - 1);
  for (std::size_t i = 1; i < times.size(); ++i) steps_s.push_back(to_seconds(times[i] - times[i - 1]));
  const double period_s = upper_median(steps_s);
  summary.rate_hz = 1 / period_s;
  for (const double step_s : steps_s) {
    if (step_s <= kGapPeriods * period_s) continue;
    ++summary.gaps;
    summary.lost += static_cast<std::size_t>(std::llround(step_s / period_s) - 1);
    summary.longest_gap_s = std::max(summary.longest_gap_s, step_s);
  }
  summary.loss = static_cast<double>(summary.lost) / static_cast<double>(summary.lost + times.size());
  return summary;
}

std::vector<EventGroup> group_events(std::span<const Event> events) {
  std::vector<EventGroup> groups;
  std::map<std::pair<std::string_view, std::string_view>, std::size_t> known;
  for (const Event& event : events) {
    const auto [place, is_new] = known.try_emplace({event.kind, event.json}, groups.size());
    if (is_new) {
      groups.push_back({event, 1, event.end});
      continue;
    }
    EventGroup& group = groups[place->second];
    ++group.count;
    group.end = std::max(group.end, event.end);
    if (event.begin < group.first.begin) group.first = event;
  }
  // What began together stands by its kind and text, so that the order is always the same.
  std::ranges::sort(groups, {}, [](const EventGroup& group) {
    return std::tuple(group.first.begin, std::string_view(group.first.kind),
                      std::string_view(group.first.json));
  });
  return groups;
}

Result<Summary> summarise(const Take& take) {
  Summary summary;
  {
    MIEN_TRY_ASSIGN(const auto entries, take.entries());
    summary.entries = entries.size();
    MIEN_TRY_ASSIGN(PayloadReader payloads, take.payloads());
    for (const LogEntry& entry : entries) {
      summary.entry_bytes += entry.bytes.size();
      MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry.id));
      if (!payload.bytes.empty()) ++summary.payloads;
      summary.payload_bytes += payload.bytes.size();
    }
    summary.duration_s = span_s(entries, [](const LogEntry& entry) { return entry.arrival; });
  }
  {
    MIEN_TRY_ASSIGN(const auto ticks, take.ticks());
    summary.ticks = ticks.size();
    if (!ticks.empty()) summary.begin = ticks.front().frame;
    summary.duration_s =
        std::max(summary.duration_s, span_s(ticks, [](const Tick& tick) { return tick.frame; }));
  }
  {
    const auto& sensors = take.rig().sensors;
    std::vector<std::vector<DeviceTime>> times(sensors.size());
    std::vector<bool> estimated(sensors.size());
    MIEN_TRY_ASSIGN(const auto samples, take.samples());
    summary.samples = samples.size();
    for (const StoredSample& stored : samples) {
      times[stored.sample.sensor].push_back(stored.sample.time);
      if (stored.sample.time_estimated) estimated[stored.sample.sensor] = true;
    }
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      summary.sensors.push_back(summarise_sensor(sensors[i].name, std::move(times[i])));
      SensorSummary& sensor = summary.sensors.back();
      sensor.time_estimated = estimated[i];
      summary.duration_s = std::max(summary.duration_s, sensor.end_s - sensor.begin_s);
    }
  }
  {
    MIEN_TRY_ASSIGN(const auto truth, take.truth());
    summary.truth_frames = truth.size();
    for (const TruthFrame& frame : truth) {
      if (!frame.has_face) ++summary.truth_lost;
      if (frame.has_face && frame.evaluated) ++summary.truth_evaluated;
    }
    summary.duration_s =
        std::max(summary.duration_s, span_s(truth, [](const TruthFrame& frame) { return frame.time; }));
  }
  MIEN_TRY_ASSIGN(const auto audio, take.audio());
  if (audio) {
    summary.audio_rate_hz = audio->rate_hz;
    summary.audio_s = static_cast<double>(audio->samples.size()) / audio->rate_hz;
    summary.duration_s = std::max(summary.duration_s, summary.audio_s);
  }
  return summary;
}

}  // namespace mien::take
