#include "mien/study/trace_features.h"

#include <optional>
#include <string_view>

#include "mien/take/session_log.h"

namespace mien::study {
namespace {

std::optional<imu::Phase> phase_of(std::string_view event_kind) {
  if (event_kind == "neutral") return imu::Phase::neutral;
  if (event_kind == "nod") return imu::Phase::nod;
  if (event_kind == "shake") return imu::Phase::shake;
  return std::nullopt;
}

}  // namespace

std::vector<model::FeatureFrame> trace_features(const sensor::Rig& rig, std::span<const take::Event> events,
                                                std::span<const take::StoredSample> samples,
                                                std::span<const take::Tick> ticks,
                                                imu::Calibration* calibration) {
  imu::Pipeline pipeline(rig);
  for (const take::Event& event : events)
    if (const auto phase = phase_of(event.kind)) pipeline.mark(*phase, event.begin, event.end);
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
