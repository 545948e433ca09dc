#pragma once

#include <optional>
#include <vector>

#include "mien/imu/pipeline.h"
#include "mien/sensor/clock_model.h"

namespace mien::imu::testing_head {

/// A pipeline beside the clock models that a session keeps for it.
class ClockedPipeline : public Pipeline {
 public:
  explicit ClockedPipeline(const sensor::Rig& rig, const PipelineSettings& settings = {})
      : Pipeline(rig, settings), lines_(rig.sensors.size(), rig.find(rig.reference)) {}

  void add(HostTime arrival, const sensor::Sample& sample) {
    lines_.add(arrival, sample);
    Pipeline::add(sample);
  }
  void forget(std::uint16_t sensor) {
    lines_.forget(sensor);
    Pipeline::forget(sensor);
  }
  std::optional<tracker::CalibrationEvent> tick(DeviceTime frame, model::FeatureFrame& out) {
    auto change = Pipeline::tick(frame, lines_, out);
    if (change) found_.insert(found_.end(), change->found.begin(), change->found.end());
    return change;
  }
  /// All steps that watching found so far.
  [[nodiscard]] const std::vector<tracker::PerformedStep>& found() const { return found_; }

 private:
  sensor::TimeLines lines_;
  std::vector<tracker::PerformedStep> found_;
};

}  // namespace mien::imu::testing_head
