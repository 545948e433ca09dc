#include "mien/virtual/prologue_calibration.h"

#include <string>
#include <utility>

#include "mien/eyewear/calibrator.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/normalisation.h"
#include "mien/imu/pipeline.h"
#include "mien/sensor/clock_model.h"
#include "mien/take/session_log.h"

namespace mien::virt {
namespace {

using Versions = std::vector<take::CalibrationVersion>;

void add_version(Versions& versions, DeviceTime made, std::string modality, std::string json) {
  const auto id = static_cast<std::int64_t>(versions.size()) + 1;
  versions.push_back({id, made, std::move(modality), std::move(json)});
}

Versions imu_calibrations(const sensor::Rig& rig, const VirtualSession& session) {
  imu::Pipeline pipeline(rig);
  for (const take::Event& event : session.events)
    if (const auto phase = imu::phase_of(event.kind)) pipeline.mark(*phase, event.begin, event.end);
  Versions versions;
  model::FeatureFrame frame;
  sensor::TimeLines lines(rig.sensors.size(), rig.find(rig.reference));
  for (const auto& step : take::replay_order(session.samples, session.ticks)) {
    if (step.item != nullptr) {
      lines.add(step.item->arrival, step.item->sample);
      pipeline.add(step.item->sample);
    }
    if (step.tick == nullptr) continue;
    if (pipeline.tick(step.tick->frame, lines, frame).kind == imu::CalibrationChange::Kind::none) continue;
    add_version(versions, step.tick->frame, "imu", imu::write_calibration(pipeline.calibration()));
  }
  return versions;
}

Versions eyewear_calibrations(const sensor::Rig& rig, const VirtualSession& session) {
  eyewear::LightGrid grid(rig);
  eyewear::Calibrator calibrator(rig);
  for (const take::Event& event : session.events) {
    if (event.kind == "neutral") calibrator.guide_neutral(event.begin, event.end);
    if (event.kind == "range") calibrator.guide_range(event.begin, event.end);
  }
  Versions versions;
  eyewear::GridLight light;
  sensor::TimeLines lines(rig.sensors.size(), rig.find(rig.reference));
  for (const auto& step : take::replay_order(session.samples, session.ticks)) {
    if (step.item != nullptr) {
      lines.add(step.item->arrival, step.item->sample);
      grid.add(step.item->sample);
    }
    if (step.tick == nullptr) continue;
    grid.tick(step.tick->frame, lines, light);
    if (calibrator.add(step.tick->frame, light) == eyewear::Calibrator::Change::none) continue;
    add_version(versions, step.tick->frame, "eyewear", eyewear::write_normalisation(calibrator.in_force()));
  }
  return versions;
}

}  // namespace

std::vector<take::CalibrationVersion> prologue_calibrations(const Stage& stage,
                                                            const VirtualSession& session) {
  if (stage.eyewear) return eyewear_calibrations(stage.rig, session);
  if (stage.lab) return {};
  return imu_calibrations(stage.rig, session);
}

}  // namespace mien::virt
