#pragma once

#include <memory>
#include <optional>

#include "mien/eyewear/calibrator.h"
#include "mien/eyewear/light_drift.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/light_model.h"
#include "mien/tracker/tracker.h"

namespace mien::eyewear {

/// Tracker of the modality "eyewear": light on the 60 Hz grid (LightGrid), normalised by the wearer's
/// calibration (Calibrator), weights by a LightModel. Head and eye directions are not observable: neutral,
/// with that provenance. Method and cost: docs/method/eyewear.md.
class EyewearTracker final : public tracker::Tracker {
 public:
  /// `regressor`: from the rig's photo-reflective sensors, in the rig's order, to the face's markers. Errors:
  /// mismatch (another number of markers; a rig without such sensors).
  [[nodiscard]] static Result<std::unique_ptr<EyewearTracker>> create(
      const sensor::Rig& rig, MarkedFace face, std::unique_ptr<MarkerRegressor> regressor);

  [[nodiscard]] std::string_view modality() const override { return "eyewear"; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void forget(std::uint16_t sensor) override;
  /// Provenance and confidence of the shapes by the regressor's table, at the share of its sensors that are
  /// present and calibrated.
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;
  /// Ten seconds of neutral, five with a calibration in force, since folds and sway last about a second; no
  /// gestures.
  [[nodiscard]] tracker::Guidance guidance() const override;
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end) override;
  void guide_range(DeviceTime begin, DeviceTime end) override;
  void cancel_guidance() override;
  [[nodiscard]] tracker::CalibrationState calibration_state() const override;
  [[nodiscard]] std::string calibration() const override;
  [[nodiscard]] std::vector<sensor::Score> scores() const override;
  [[nodiscard]] Result<void> restore(std::string_view json) override;

 private:
  EyewearTracker(const sensor::Rig& rig, LightModel model);
  /// Features of light_, `since_s` seconds after the last ones, by the calibration in force and less what has
  /// drifted; returns the number of sensors present.
  std::size_t normalise(double since_s);

  std::vector<std::uint16_t> sensors_;  // Numbers in the rig.
  LightGrid grid_;
  Calibrator calibrator_;
  LightDrift drift_;
  LightModel model_;

  GridLight light_;
  LightFrame features_;
  bool renewed_ =
      false;  // The calibration has changed since the last frame: drift and regressor are reset first.
  std::optional<DeviceTime> last_frame_;
};

}  // namespace mien::eyewear
