#include "mien/study/imu/trace_features.h"

#include "mien/take/session_log.h"

namespace mien::study {

std::vector<model::FeatureFrame> trace_features(const sensor::Rig& rig, std::span<const take::Event> events,
                                                std::span<const take::StoredSample> samples,
                                                std::span<const take::Tick> ticks,
                                                const imu::PipelineSettings& settings,
                                                imu::Calibration* calibration) {
  imu::Pipeline pipeline(rig, settings);
  for (const take::Event& event : events)
    if (const auto phase = imu::phase_of(event.kind)) pipeline.mark(*phase, event.begin, event.end);
  std::vector<model::FeatureFrame> frames;
  frames.reserve(ticks.size());
  for (const auto& step : take::replay_order(samples, ticks)) {
    if (step.item != nullptr) pipeline.add(step.item->arrival, step.item->sample);
    if (step.tick != nullptr) pipeline.tick(step.tick->frame, frames.emplace_back());
  }
  if (calibration != nullptr) *calibration = pipeline.calibration();
  return frames;
}

}  // namespace mien::study
