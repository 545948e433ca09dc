#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/shaping/merge.h"
#include "mien/shaping/settings.h"
#include "mien/tracker/tracker.h"

namespace mien::shaping {

/// Several modalities' trackers as one: each is asked at every frame, and Merge makes one answer of theirs.
/// Whoever holds it need not know that there are several.
///
/// Each tracker gets the samples of its own sensors. It is made of the rig's part that is its own
/// (sensor::part_of), where all sensors keep their numbers.
///
/// Calibration: guided steps go to all, as long as the one that wants them longest asks for. Where trackers
/// must be told apart, those count that have a sensor there, heard in the last two seconds, and all while
/// none has: a pair of glasses that lies on the table keeps nothing from being done. A guided calibration
/// that fails for one tracker has its hint, and the others keep what they made of it.
class CombinedTracker final : public tracker::Tracker {
 public:
  struct Part {
    std::unique_ptr<tracker::Tracker> tracker;
    std::vector<std::uint16_t> sensors;  ///< Its own, by their numbers in the rig.
  };
  /// `parts`: 1 to Merge::kMostSources, of different modalities. `settings`: its merge and fallback.
  explicit CombinedTracker(std::vector<Part> parts, const ShaperSettings& settings = {});

  /// Takes effect at the next frame.
  void set(const ShaperSettings& settings) { merge_.set(settings.merge, settings.fallback); }

  /// "imu+eyewear".
  [[nodiscard]] std::string_view modality() const override { return modality_; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void forget(std::uint16_t sensor) override;
  /// `sensors_present`: how many stand behind the answer (Merge::apply). Calibration events are those of all.
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;

  [[nodiscard]] tracker::Guidance guidance() const override;
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end) override;
  void guide_range(DeviceTime begin, DeviceTime end) override;
  void guide_expression(const tracker::PromptedExpression& asked) override;
  void cancel_guidance() override;
  /// Guided while one is; done when all are; the step and the hint of the first that has one.
  [[nodiscard]] tracker::CalibrationState calibration_state() const override;
  /// {"imu": {...}, "eyewear": {...}}: those that are in force.
  [[nodiscard]] std::string calibration() const override;
  [[nodiscard]] std::vector<sensor::Score> scores() const override;
  /// A tracker that the text does not name keeps what it has. What fails leaves all as it was, but for
  /// trackers that had none in force before. Errors: malformed, mismatch (no tracker is called so), a
  /// tracker's own.
  [[nodiscard]] Result<void> restore(std::string_view json) override;
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t sensor) const override;

 private:
  struct Member {
    std::unique_ptr<tracker::Tracker> tracker;
    std::vector<std::uint16_t> sensors;
    std::optional<HostTime> received;  // The newest sample of its own sensors.
    face::OutputFrame frame;
  };
  [[nodiscard]] bool any_there() const;
  /// Whether it is one of those that count.
  [[nodiscard]] bool counts(const Member& member) const;

  std::vector<Member> members_;
  std::vector<std::uint8_t> member_of_;  // By number in the rig.
  std::string modality_;
  Merge merge_;
  std::vector<Merge::Source> sources_;
  HostTime newest_;
  bool half_restored_ =
      false;  // A restore failed, and what it had changed could not be undone: next tick's event.
};

}  // namespace mien::shaping
