#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mien/imu/pipeline.h"
#include "mien/imu/ready_rotations.h"
#include "mien/tracker/frame_model.h"
#include "mien/tracker/tracker.h"
#include "mien/tracker/wearer_learner.h"

namespace mien::imu {

/// Tracker of the modality "imu": fusion, calibration and removal of the head's motion (Pipeline), then a
/// frame model.
class ImuTracker final : public tracker::Tracker {
 public:
  /// `model` takes features of the rig's face sensors, in the rig's order. Null: the tracker calibrates and
  /// gives features(), and its frames are neutral.
  ImuTracker(const sensor::Rig& rig, std::unique_ptr<tracker::FrameModel> model,
             const PipelineSettings& settings = live_settings());
  /// Default settings with self-calibration, for live sessions.
  [[nodiscard]] static PipelineSettings live_settings();

  [[nodiscard]] std::string_view modality() const override { return "imu"; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void forget(std::uint16_t sensor) override;
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;
  [[nodiscard]] const model::FeatureFrame* features() const override { return &features_; }
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end) override;
  [[nodiscard]] tracker::Guidance guidance() const override;
  void guide_range(DeviceTime begin, DeviceTime end) override;
  void guide_expression(const tracker::PromptedExpression& asked) override;
  void cancel_guidance() override;
  [[nodiscard]] Duration wants_rest() const override;
  void rest(DeviceTime begin, DeviceTime end) override;
  [[nodiscard]] tracker::CalibrationState calibration_state() const override;
  [[nodiscard]] std::string calibration() const override;
  [[nodiscard]] std::vector<sensor::Score> scores() const override;
  [[nodiscard]] Result<void> restore(std::string_view json) override;
  [[nodiscard]] Result<void> correct(const model::Correction& correction) override;
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t sensor) const override;
  [[nodiscard]] std::optional<tracker::SensorCertainty> certainty(std::uint16_t sensor) const override;
  [[nodiscard]] std::uint64_t faults() const override;

 private:
  /// What is known of the wearer, in force.
  struct Wearer {
    std::vector<float> slopes;                    // Empty: the model's own.
    std::optional<model::Correction> correction;  // None: the model's own.
    std::optional<sensor::Score> score;           // Of the last guided calibration.
  };
  /// The model file for which a wearer can be learnt; null: none.
  [[nodiscard]] const model::ModelFile* personal() const {
    return model_ != nullptr ? model_->personal() : nullptr;
  }
  /// Whether the guided calibration passes its scores; sets hint_ otherwise.
  bool passes_checks();
  /// Ends guidance and keeps its calibration.
  void end_guidance();
  /// Ends guidance and restores what was in force before it.
  void revert_guidance();
  void use(Wearer wearer);

  std::vector<std::uint16_t> face_;  // Numbers in the rig.
  Pipeline pipeline_;
  ReadyRotations ready_;
  std::unique_ptr<tracker::FrameModel> model_;
  model::FeatureFrame features_;
  std::optional<DeviceTime> guided_until_;  // End of the guided steps.
  std::optional<DeviceTime> asked_until_;   // End of guidance, learning included.
  std::string_view hint_;
  tracker::WearerLearner learner_;
  Wearer wearer_, wearer_before_;  // The latter: in force when guidance began.
};

}  // namespace mien::imu
