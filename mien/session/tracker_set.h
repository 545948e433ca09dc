#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/output_frame.h"
#include "mien/sensor/calibration.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/picture_view.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"
#include "mien/shaping/merge.h"
#include "mien/shaping/retiming.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

/// A session's trackers, one a modality; none in a session that only receives. Each gets the samples of its
/// own sensors and estimates every frame; shaping::Shaper merges their estimates.
///
/// The modality "speech" is asked for the frame's time and the lag that Retiming finds between sound and the
/// jaw that another tracker senses.
///
/// Calibration: guided steps go to all trackers, for the longest time that any of them asks for. A tracker
/// without a sample in the last two seconds does not count (all count while none has samples), so that
/// glasses left on the table block nothing. Where a guided calibration fails for one tracker its hint is
/// shown, and the others keep theirs.
///
/// Thread: one at a time. No allocation in add() and tick() but a tracker's own.
class TrackerSet {
 public:
  /// Each is of the rig's sensors whose kind is its modality. At most Merge::kMostSources, of different
  /// modalities.
  TrackerSet(const sensor::Rig& rig, std::vector<std::unique_ptr<tracker::Tracker>> trackers);

  [[nodiscard]] bool empty() const { return members_.empty(); }
  /// "imu+eyewear"; empty for none.
  [[nodiscard]] std::string_view modality() const { return modality_; }
  [[nodiscard]] std::vector<std::string> modalities() const;

  /// A decoded sample; `payload`: empty for none.
  void add(HostTime arrival, const sensor::Sample& sample, std::span<const std::byte> payload);
  void forget(std::uint16_t sensor);
  void change_view(std::uint16_t sensor, const sensor::PictureView& view);

  /// What a tick returns beside the estimates (sources()): of all trackers.
  struct Answer {
    std::vector<tracker::CalibrationEvent> calibration;
    std::optional<tracker::TickResult::Hearing> hearing;
    std::optional<tracker::RestOutcome> rested;
  };
  Answer tick(DeviceTime frame, const sensor::TimeLines& lines);
  /// Each tracker's estimate of the last tick's frame, which merging may mend in place.
  [[nodiscard]] std::span<const shaping::Merge::Source> sources() const { return sources_; }
  /// Compares the jaw estimated from sound with the one that is sensed: after the frame was merged. `behind`:
  /// Hearing's. `sure`: the explained share from which a jaw counts as sensed (MergeSettings).
  void follow_lag(Duration behind, float sure);
  [[nodiscard]] const shaping::Retiming& retiming() const { return retiming_; }
  /// From what the last frame was estimated (tracker::Tracker::features()): of the first tracker that has
  /// some; null for none.
  [[nodiscard]] const model::FeatureFrame* features() const;

  [[nodiscard]] tracker::Guidance guidance() const;
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end);
  void guide_range(DeviceTime begin, DeviceTime end);
  void guide_expression(const tracker::PromptedExpression& asked);
  void guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end);
  void cancel_guidance();
  /// The longest of those that count.
  [[nodiscard]] Duration wants_rest() const;
  void rest(DeviceTime begin, DeviceTime end);
  /// Guided while any is; done when all are; step and hint of the first that has one.
  [[nodiscard]] tracker::CalibrationState calibration_state() const;
  /// Calibrations in force: a lone tracker's own, of several {"imu": {...}, "eyewear": {...}}; empty for
  /// none.
  [[nodiscard]] std::string calibration() const;
  [[nodiscard]] std::vector<sensor::Score> scores() const;
  /// Trackers that the text does not name keep theirs. On an error the trackers already changed are restored,
  /// except where one had none in force before. Errors: malformed, mismatch (no tracker of that name), a
  /// tracker's own.
  [[nodiscard]] Result<void> restore(std::string_view json);
  /// The first tracker that takes it is corrected. Errors: unsupported (none does), a tracker's own.
  [[nodiscard]] Result<void> correct(const model::Correction& correction);
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t sensor) const;
  [[nodiscard]] std::optional<tracker::SensorCertainty> certainty(std::uint16_t sensor) const;
  /// All trackers'.
  [[nodiscard]] std::uint64_t faults() const;

 private:
  struct Member {
    std::unique_ptr<tracker::Tracker> tracker;
    std::optional<HostTime> received;  // Arrival of its sensors' newest sample.
    face::OutputFrame frame;
    std::optional<tracker::Explained> explained;
    bool listens = false;  // Of the modality "speech".
  };
  tracker::TickResult tick(Member& member, DeviceTime frame, const sensor::TimeLines& lines) const;
  [[nodiscard]] bool any_present() const;
  /// The member that has the sensor; null for none.
  [[nodiscard]] const Member* member_with(std::uint16_t sensor) const;
  /// Whether its calibration state counts (class comment).
  [[nodiscard]] bool counts(const Member& member) const;

  std::vector<Member> members_;
  std::vector<std::uint8_t> member_of_;  // By number in the rig.
  std::string modality_;
  shaping::Retiming retiming_;
  std::vector<shaping::Merge::Source> sources_;
  HostTime newest_;
  bool half_restored_ = false;  // A failed restore() could not be undone: an event at the next tick.
};

}  // namespace mien::session
