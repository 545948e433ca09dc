#include "mien/take/summary.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "mien/core/median.h"

namespace mien::take {
namespace {

constexpr double kGapPeriods = 1.5;

/// A clock that is so much further than what went by until the sample came, or so far back, went on
/// elsewhere.
constexpr Duration kLeapAhead = std::chrono::seconds(2), kLeapBack = std::chrono::seconds(1);

template <class Items, class Time>
double span_s(const Items& items, Time time) {
  return items.empty() ? 0 : to_seconds(std::invoke(time, items.back()) - std::invoke(time, items.front()));
}

/// Parts of a sensor's samples between which its clock leapt.
std::vector<std::vector<SampleTime>> between_leaps(std::span<const SampleTime> samples) {
  std::vector<std::vector<SampleTime>> out(1);
  for (const SampleTime& sample : samples) {
    if (!out.back().empty()) {
      const SampleTime& before = out.back().back();
      const Duration step = sample.time - before.time;
      if (step < -kLeapBack || step > (sample.arrival - before.arrival) + kLeapAhead) out.emplace_back();
    }
    out.back().push_back(sample);
  }
  return out;
}

/// How many numbers lie between two samples; they wrap. None where they run back.
std::size_t missing_between(const SampleTime& before, const SampleTime& after) {
  const auto ahead = static_cast<std::int32_t>(after.sequence - before.sequence);
  return ahead > 1 ? static_cast<std::size_t>(ahead) - 1 : 0;
}

/// Whether it is a part of a face that another program told.
bool is_told(const sensor::Sample& sample) {
  return sample.kind == sensor::SampleKind::weights ||
         sample.kind == sensor::SampleKind::weights_confidence ||
         sample.kind == sensor::SampleKind::head_pose;
}

}  // namespace

SensorSummary summarise_sensor(std::string name, std::span<const SampleTime> samples, bool numbered) {
  SensorSummary summary;
  summary.name = std::move(name);
  summary.samples = samples.size();
  if (samples.empty()) return summary;
  std::vector<std::vector<SampleTime>> stretches = between_leaps(samples);
  summary.leaps = stretches.size() - 1;
  std::size_t heard = 0;
  std::vector<double> steps_s;
  for (std::vector<SampleTime>& stretch : stretches) {
    std::ranges::sort(stretch, {}, &SampleTime::time);
    const auto doubled = std::ranges::unique(stretch, {}, &SampleTime::time);
    summary.doubled += doubled.size();
    stretch.erase(doubled.begin(), doubled.end());
    heard += stretch.size();
    summary.heard_s += span_s(stretch, &SampleTime::time);
    for (std::size_t i = 1; i < stretch.size(); ++i)
      steps_s.push_back(to_seconds(stretch[i].time - stretch[i - 1].time));
  }
  summary.begin_s = to_seconds(stretches.front().front().time.time_since_epoch());
  summary.end_s = to_seconds(stretches.back().back().time.time_since_epoch());
  if (steps_s.empty()) return summary;

  const double period_s = upper_median(steps_s);
  summary.rate_hz = 1 / period_s;
  for (const std::vector<SampleTime>& stretch : stretches)
    for (std::size_t i = 1; i < stretch.size(); ++i) {
      const double step_s = to_seconds(stretch[i].time - stretch[i - 1].time);
      const auto missing = numbered ? missing_between(stretch[i - 1], stretch[i])
                           : step_s > kGapPeriods * period_s
                               ? static_cast<std::size_t>(std::llround(step_s / period_s) - 1)
                               : 0;
      if (missing == 0) continue;
      ++summary.gaps;
      summary.lost += missing;
      summary.longest_gap_s = std::max(summary.longest_gap_s, step_s);
    }
  summary.loss = static_cast<double>(summary.lost) / static_cast<double>(summary.lost + heard);
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
    MIEN_TRY_ASSIGN(EntryReader log, take.log());
    MIEN_TRY_ASSIGN(PayloadReader payloads, take.payloads());
    std::optional<HostTime> first;
    for (;;) {
      MIEN_TRY_ASSIGN(const LogEntry* const entry, log.next());
      if (entry == nullptr) break;
      ++summary.entries;
      summary.entry_bytes += entry->bytes.size();
      MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry->id));
      if (!payload.bytes.empty()) ++summary.payloads;
      summary.payload_bytes += payload.bytes.size();
      if (!first) first = entry->arrival;
      summary.duration_s = to_seconds(entry->arrival - *first);
    }
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
    std::vector<std::vector<SampleTime>> times(sensors.size());
    std::vector<bool> estimated(sensors.size()), told(sensors.size());
    std::int64_t entry = 0;
    MIEN_TRY(take.visit_samples([&](const StoredSample& stored) {
      ++summary.samples;
      const sensor::Sample& sample = stored.sample;
      std::vector<SampleTime>& of = times[sample.sensor];
      if (sample.time_estimated) estimated[sample.sensor] = true;
      if (is_told(sample)) told[sample.sensor] = true;
      const bool further_part =
          is_told(sample) && !of.empty() && stored.entry == entry && of.back().time == sample.time;
      entry = stored.entry;
      if (!further_part) of.push_back({sample.time, stored.arrival, sample.sequence});
    }));
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      summary.sensors.push_back(summarise_sensor(sensors[i].name, times[i], told[i] && !estimated[i]));
      SensorSummary& sensor = summary.sensors.back();
      sensor.role = sensors[i].role;
      sensor.time_estimated = estimated[i];
      summary.duration_s = std::max(summary.duration_s, sensor.heard_s);
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
