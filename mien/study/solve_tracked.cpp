#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "mien/study/solve.h"
#include "mien/take/session_log.h"

// The half of solve.h that drives a tracker, whatever its sensors are.
namespace mien::study {
namespace {

using take::StoredSample;

/// Decodes the raw packets again. Which sensor a device's channel is at, the samples stored beside an entry
/// say: they came from its readings, in their order.
class LogDecoder {
 public:
  LogDecoder(std::span<const std::unique_ptr<sensor::Protocol>> protocols,
             const std::vector<StoredSample>& stored)
      : protocols_(protocols), stored_(stored) {}

  std::vector<StoredSample> decode(const std::vector<take::LogEntry>& entries) {
    std::vector<StoredSample> out;
    out.reserve(stored_.size());
    for (const take::LogEntry& entry : entries) {
      const auto begin = next_;
      while (next_ < stored_.size() && stored_[next_].entry == entry.id) ++next_;
      inbox_.clear();
      const auto peer = peers_.emplace(entry.source, static_cast<sensor::Peer>(peers_.size())).first->second;
      for (const auto& protocol : protocols_)
        if (protocol->recognises(entry.bytes)) {
          protocol->receive(entry.arrival, peer, entry.bytes, inbox_);
          break;
        }
      name_sensors(std::span(stored_).subspan(begin, next_ - begin));
      if (next_ == begin) continue;  // Not of this rig, or not bound yet.
      for (const sensor::Reading& reading : inbox_.readings)
        if (const auto known = sensors_.find(reading.from); known != sensors_.end()) {
          out.push_back({entry.id, entry.arrival, reading.sample});
          out.back().sample.sensor = known->second;
        }
    }
    return out;
  }

 private:
  static bool same(const sensor::Sample& a, const sensor::Sample& b) {
    return a.kind == b.kind && a.sequence == b.sequence && a.time == b.time &&
           std::ranges::equal(a.used(), b.used());
  }
  void name_sensors(std::span<const StoredSample> kept) {
    if (inbox_.readings.empty() || kept.empty()) return;
    auto next = kept.begin();
    for (const sensor::Reading& reading : inbox_.readings) {
      if (next == kept.end()) break;
      if (!same(reading.sample, next->sample)) continue;  // Of a sensor that the rig lacks.
      sensors_[reading.from] = next->sample.sensor;
      ++next;
    }
  }

  std::span<const std::unique_ptr<sensor::Protocol>> protocols_;
  const std::vector<StoredSample>& stored_;
  std::size_t next_ = 0;
  sensor::Inbox inbox_;
  std::map<std::string, sensor::Peer> peers_;  // In the order of their first words, as live.
  std::map<sensor::DeviceKey, std::uint16_t> sensors_;
};

void guide_by_events(const std::vector<take::Event>& events, tracker::Tracker& tracker) {
  for (const take::Event& event : events) {
    if (const tracker::Step step = tracker::step_named(event.kind); step != tracker::Step::none)
      tracker.guide(step, event.begin, event.end);
    else if (event.kind == "range")
      tracker.guide_range(event.begin, event.end);
  }
}

}  // namespace

Result<Solution> solve_take(const take::Take& take, tracker::Tracker& tracker,
                            std::span<const std::unique_ptr<sensor::Protocol>> protocols, SolveFrom from,
                            const Progress& progress) {
  MIEN_TRY_ASSIGN(std::vector<StoredSample> samples, take.samples());
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(),
                "record or perform it again");
  if (from == SolveFrom::log) {
    MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
    samples = LogDecoder(protocols, samples).decode(entries);
  }
  MIEN_TRY_ASSIGN(std::vector<take::CalibrationVersion> calibrations, take.calibrations());
  std::erase_if(calibrations, [&](const auto& made) { return made.modality != tracker.modality(); });
  if (calibrations.empty()) {
    MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
    guide_by_events(events, tracker);
  }

  constexpr std::size_t kShownEvery = 600;
  Solution out;
  out.frames.reserve(ticks.size());
  auto calibration = calibrations.begin();
  std::size_t felt = 0, measured = 0;
  for (const auto& step : take::replay_order(samples, ticks)) {
    if (step.item != nullptr) tracker.add(step.item->arrival, step.item->sample);
    if (step.tick == nullptr) continue;
    for (; calibration != calibrations.end() && calibration->made <= step.tick->frame; ++calibration)
      MIEN_TRY(tracker.restore(calibration->json));
    face::OutputFrame& frame = out.frames.emplace_back();
    const std::size_t there = tracker.tick(step.tick->frame, frame);
    const bool neutral = std::ranges::count(frame.provenance, face::Provenance::neutral) > 0;
    if (!neutral) {
      felt += there;
      ++measured;
    }
    const std::size_t done = out.frames.size();
    if (done % kShownEvery == 0 &&
        !progress(static_cast<double>(done) / static_cast<double>(ticks.size()), "frame by frame"))
      return fail(ErrorCode::cancelled, "stopped while solving");
  }
  progress(1, "frame by frame");
  const std::size_t all = measured * take.rig().sensors.size();
  out.felt = all > 0 ? static_cast<double>(felt) / static_cast<double>(all) : 0;
  out.hash = hash_frames(out.frames);
  return out;
}

}  // namespace mien::study
