#pragma once

#include <span>
#include <vector>

#include "mien/imu/pipeline.h"
#include "mien/model/features.h"
#include "mien/sensor/rig.h"
#include "mien/take/take.h"

namespace mien::study {

/// The features of a recorded session, one frame a tick: its samples and ticks in the log's order through the
/// IMU pipeline, with the prologue's events as its marks. `calibration`, when asked for, is the one in force
/// at the end.
[[nodiscard]] std::vector<model::FeatureFrame> trace_features(const sensor::Rig& rig,
                                                              std::span<const take::Event> events,
                                                              std::span<const take::StoredSample> samples,
                                                              std::span<const take::Tick> ticks,
                                                              const imu::PipelineSettings& settings = {},
                                                              imu::Calibration* calibration = nullptr);

}  // namespace mien::study
