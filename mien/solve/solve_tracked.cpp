#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "mien/modalities/modalities.h"
#include "mien/session/prompt.h"
#include "mien/session/replay.h"
#include "mien/solve/solve.h"

// The half of solve.h that drives a tracker, whatever its sensors are.
namespace mien::solve {
namespace {

/// Hands samples to a tracker.
class TrackerFeed final : public session::SampleConsumer {
 public:
  explicit TrackerFeed(tracker::Tracker& tracker) : tracker_(tracker) {}
  void add(HostTime arrival, const sensor::Sample& sample) override { tracker_.add(arrival, sample); }
  void add_with_payload(HostTime arrival, const sensor::Sample& sample,
                        std::span<const std::byte> payload) override {
    tracker_.add_with_payload(arrival, sample, payload);
  }
  void rebound(std::uint16_t sensor, const sensor::DeviceKey&, bool) override { tracker_.forget(sensor); }
  void view_changed(std::uint16_t sensor, const sensor::PictureView& view, bool) override {
    tracker_.change_view(sensor, view);
  }

 private:
  tracker::Tracker& tracker_;
};

/// A solution that grows frame by frame.
class Collected {
 public:
  Collected(const take::Take& take, std::size_t ticks, const Progress& progress)
      : sensors_(take.rig().sensors.size()), ticks_(ticks), progress_(progress) {
    out_.frames.reserve(ticks);
    out_.sensors_present.reserve(ticks);
  }
  /// False when it is to stop.
  bool add(const face::OutputFrame& frame, std::size_t sensors_present) {
    constexpr std::size_t kShownEvery = 600;
    out_.frames.push_back(frame);
    out_.sensors_present.push_back(sensors_present);
    const auto neutral =
        static_cast<std::size_t>(std::ranges::count(frame.provenance, face::Provenance::neutral));
    if (neutral == 0) whole_.add(sensors_present);
    if (neutral < frame.provenance.size() && sensors_present > 0) part_.add(sensors_present);
    const std::size_t done = out_.frames.size();
    return done % kShownEvery != 0 ||
           progress_(static_cast<double>(done) / static_cast<double>(ticks_), "frame by frame");
  }
  Solution finish(bool uncalibrated) {
    progress_(1, "frame by frame");
    const Tally& told = whole_.frames > 0 ? whole_ : part_;
    const std::size_t all = told.frames * sensors_;
    out_.observed = all > 0 ? static_cast<double>(told.present) / static_cast<double>(all) : 0;
    out_.uncalibrated = uncalibrated;
    out_.hash = hash_frames(out_.frames);
    return std::move(out_);
  }

 private:
  struct Tally {
    std::size_t present = 0, frames = 0;
    void add(std::size_t sensors_present) {
      present += sensors_present;
      ++frames;
    }
  };
  Solution out_;
  std::size_t sensors_;
  std::size_t ticks_;
  const Progress& progress_;
  Tally whole_;  // Of frames without a neutral shape, ...
  Tally part_;   // ... and of those of which a sensor tells some shape.
};

}  // namespace

void guide_by_events(std::span<const take::Event> events, tracker::Tracker& tracker) {
  for (const take::Event& event : events) {
    if (const tracker::Step step = tracker::step_named(event.kind); step != tracker::Step::none)
      tracker.guide(step, event.begin, event.end);
    else if (event.kind == "range")
      tracker.guide_range(event.begin, event.end);
    else if (event.kind == "gaze")
      if (const face::GazeTarget* const target = session::gaze_event_target(event.json))
        tracker.guide_gaze(*target, event.begin, event.end);
  }
}

Result<Solution> solve_take(const take::Take& take, tracker::Tracker& tracker, const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(),
                "record or perform it again");
  MIEN_TRY_ASSIGN(auto protocols, modalities::make_protocols());
  MIEN_TRY_ASSIGN(const auto receiver, session::Receiver::create(take.rig(), std::move(protocols)));
  MIEN_TRY_ASSIGN(std::vector<take::CalibrationVersion> calibrations, take.calibrations());
  std::erase_if(calibrations, [&](const auto& made) { return made.modality != tracker.modality(); });
  if (calibrations.empty()) {
    MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
    guide_by_events(events, tracker);
  }

  Collected out(take, ticks.size(), progress);
  TrackerFeed feed(tracker);
  auto calibration = calibrations.begin();
  Result<void> restored;
  face::OutputFrame frame;
  const auto ticked = [&](const take::Tick& tick) {
    for (; calibration != calibrations.end() && calibration->made <= tick.frame; ++calibration)
      if (restored = tracker.restore(calibration->json); !restored) return false;
    const tracker::TickResult tracked = tracker.tick(tick.frame, receiver->lines(), frame);
    return out.add(frame, tracked.sensors_present);
  };
  MIEN_TRY_ASSIGN(const bool whole, session::replay_samples(take, ticks, *receiver, feed, ticked));
  MIEN_TRY(restored);
  if (!whole) return fail(ErrorCode::cancelled, "stopped while solving");
  return out.finish(tracker.calibration_state().phase == tracker::CalibrationState::Phase::watching);
}

Result<Solution> replay_take(const take::Take& take, const std::filesystem::path& model,
                             const Progress& progress, const shaping::ShaperSettings& settings) {
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  MIEN_TRY_ASSIGN(const std::unique_ptr<session::Session> session,
                  modalities::make_session(take.rig(), model, settings));
  Collected out(take, ticks.size(), progress);
  MIEN_TRY(session::replay(take, *session, [&](const take::Tick&, const face::OutputFrame& frame) {
    return out.add(frame, session->sensors_present());
  }));
  session::Report report;
  session->report(ticks.empty() ? HostTime() : ticks.back().fired, report);
  Solution replayed = out.finish(report.calibration.state == "watching" ||
                                 (report.calibration.state == "failed" && report.calibration.in_force == 0));
  replayed.shaped = true;
  return replayed;
}

}  // namespace mien::solve
