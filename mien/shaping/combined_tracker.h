#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/shaping/merge.h"
#include "mien/shaping/retiming.h"
#include "mien/shaping/settings.h"
#include "mien/tracker/tracker.h"

namespace mien::shaping {

/// Several modalities' trackers as one Tracker: all compute every frame, and Merge combines their frames.
///
/// Each tracker receives the samples of its own sensors, and is made for its part of the rig
/// (sensor::part_of), in which sensors keep their numbers.
///
/// What the modality "speech" hears is asked for at the frame's time and the lag that Retiming has found
/// between it and the jaw of whoever senses that.
///
/// Calibration: guided steps go to all trackers, for the longest time that any of them asks for. Trackers
/// without a sample in the last two seconds do not count (all count while none has samples), so that glasses
/// left on the table block nothing. Where a guided calibration fails for one tracker its hint is shown, and
/// the others keep theirs.
class CombinedTracker final : public tracker::Tracker {
 public:
  struct Part {
    std::unique_ptr<tracker::Tracker> tracker;
    std::vector<std::uint16_t> sensors;  ///< Its sensors, by their numbers in the rig.
  };
  /// `parts`: 1 to Merge::kMostSources, of different modalities. Of `settings` only merge, fallback and
  /// whether the merge is off are used.
  explicit CombinedTracker(std::vector<Part> parts, const ShaperSettings& settings = {});

  /// Takes effect at the next frame.
  void set(const ShaperSettings& settings) {
    merge_.set(settings.merge, settings.fallback, settings.runs(ChainStep::merge));
    sure_ = settings.merge.sure;
  }

  /// What was found of the lag between sound and face.
  [[nodiscard]] const Retiming& retiming() const { return retiming_; }

  /// "imu+eyewear".
  [[nodiscard]] std::string_view modality() const override { return modality_; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void add_with_payload(HostTime arrival, const sensor::Sample& sample,
                        std::span<const std::byte> payload) override;
  void forget(std::uint16_t sensor) override;
  void change_view(std::uint16_t sensor, const sensor::PictureView& view) override;
  /// `sensors_present`: of the sources of the frame (Merge::apply). Calibration events: all trackers'.
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;

  [[nodiscard]] tracker::Guidance guidance() const override;
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end) override;
  void guide_range(DeviceTime begin, DeviceTime end) override;
  void guide_expression(const tracker::PromptedExpression& asked) override;
  void guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) override;
  void cancel_guidance() override;
  /// The longest of those that count.
  [[nodiscard]] Duration wants_rest() const override;
  void rest(DeviceTime begin, DeviceTime end) override;
  /// Guided while any is; done when all are; step and hint of the first that has one.
  [[nodiscard]] tracker::CalibrationState calibration_state() const override;
  /// {"imu": {...}, "eyewear": {...}}: calibrations in force.
  [[nodiscard]] std::string calibration() const override;
  [[nodiscard]] std::vector<sensor::Score> scores() const override;
  /// Trackers that the text does not name keep theirs. On an error the trackers already changed are restored,
  /// except where one had none in force before. Errors: malformed, mismatch (no tracker of that name), a
  /// tracker's own.
  [[nodiscard]] Result<void> restore(std::string_view json) override;
  /// The first tracker that takes it is corrected.
  [[nodiscard]] Result<void> correct(const model::Correction& correction) override;
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t sensor) const override;
  [[nodiscard]] std::optional<tracker::SensorCertainty> certainty(std::uint16_t sensor) const override;
  /// All trackers'.
  [[nodiscard]] std::uint64_t faults() const override;

 private:
  struct Member {
    std::unique_ptr<tracker::Tracker> tracker;
    std::vector<std::uint16_t> sensors;
    std::optional<HostTime> received;  // Arrival of its sensors' newest sample.
    face::OutputFrame frame;
    std::optional<tracker::Explained> explained;
    bool listens = false;  // Of the modality that hears.
  };
  /// Asks the member for its frame; the one that listens at the time that belongs to the face.
  tracker::TickResult tick(Member& member, DeviceTime frame, const sensor::TimeLines& lines) const;
  /// Compares the jaw that is heard with the one that is sensed.
  void follow_lag(Duration behind);
  [[nodiscard]] bool any_present() const;
  /// The member that owns the sample's sensor, with its arrival noted; null for none.
  Member* received(HostTime arrival, const sensor::Sample& sample);
  /// Whether its calibration state counts (class comment).
  [[nodiscard]] bool counts(const Member& member) const;

  std::vector<Member> members_;
  std::vector<std::uint8_t> member_of_;  // By number in the rig.
  std::string modality_;
  Merge merge_;
  float sure_;
  Retiming retiming_;
  std::vector<Merge::Source> sources_;
  HostTime newest_;
  bool half_restored_ = false;  // A failed restore() could not be undone: an event at the next tick.
};

}  // namespace mien::shaping
