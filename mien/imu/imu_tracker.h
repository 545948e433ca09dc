#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mien/imu/pipeline.h"
#include "mien/tracker/frame_model.h"
#include "mien/tracker/tracker.h"
#include "mien/tracker/wearer_learner.h"

namespace mien::imu {

/// The skin's IMUs as a tracker: fusion, calibration and removal of the head (Pipeline), then a frame model.
class ImuTracker final : public tracker::Tracker {
 public:
  /// `model` answers for the rig's face sensors, in the rig's order.
  ImuTracker(const sensor::Rig& rig, std::unique_ptr<tracker::FrameModel> model,
             const PipelineSettings& settings = watching());
  /// The live session's settings: calibrates itself.
  [[nodiscard]] static PipelineSettings watching();

  [[nodiscard]] std::string_view modality() const override { return "imu"; }
  void add(HostTime arrival, const sensor::Sample& sample) override;
  void forget(std::uint16_t sensor) override;
  tracker::TickResult tick(DeviceTime frame, const sensor::TimeLines& lines, face::OutputFrame& out) override;
  void guide(tracker::Step step, DeviceTime begin, DeviceTime end) override;
  [[nodiscard]] tracker::Guidance guidance() const override;
  void guide_range(DeviceTime begin, DeviceTime end) override;
  void guide_expression(const tracker::PromptedExpression& asked) override;
  void cancel_guidance() override;
  [[nodiscard]] tracker::CalibrationState calibration_state() const override;
  [[nodiscard]] std::string calibration() const override;
  [[nodiscard]] std::vector<sensor::Score> scores() const override;
  [[nodiscard]] Result<void> restore(std::string_view json) override;
  [[nodiscard]] std::optional<double> heading_sigma_rad(std::uint16_t sensor) const override;

 private:
  /// The wearer in force.
  struct Wearer {
    std::vector<float> slopes;           // Empty: the model's own.
    std::optional<sensor::Score> score;  // Of the calibration that was guided last.
  };
  /// Of the calibration that guidance made; says in hint_ why not.
  bool holds_together();
  /// Guidance is over: what it made stays.
  void settle();
  /// What guidance made is undone.
  void undo();
  void use(Wearer wearer);

  std::vector<std::uint16_t> face_;  // Numbers in the rig.
  Pipeline pipeline_;
  std::unique_ptr<tracker::FrameModel> model_;
  model::FeatureFrame features_;
  std::optional<DeviceTime> guided_until_;  // Its steps' end.
  std::optional<DeviceTime> asked_until_;   // The end of all that it asks for and learns.
  std::string_view hint_;
  tracker::WearerLearner learner_;
  Wearer wearer_, wearer_before_;  // The latter: when guidance began.
};

}  // namespace mien::imu
