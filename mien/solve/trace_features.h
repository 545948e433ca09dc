#pragma once

#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/imu/imu_tracker.h"
#include "mien/imu/pipeline.h"
#include "mien/model/features.h"
#include "mien/sensor/rig.h"
#include "mien/take/take.h"

namespace mien::solve {

/// The features of a session, one frame a tick: its log replayed (session::replay()) by the IMUs' tracker
/// without a network. `events`: of the performance, which begins with the calibration that they are of.
/// Errors: the receiver's.
[[nodiscard]] Result<std::vector<model::FeatureFrame>> trace_features(
    const sensor::Rig& rig, std::span<const take::Event> events, std::span<const take::LogEntry> entries,
    std::span<const take::Tick> ticks,
    const imu::PipelineSettings& settings = imu::ImuTracker::live_settings());

/// The same of a take, recorded or performed: as its session had them. Where a recorded take's models are not
/// installed its guided calibrations are those that IMUs alone ask for. Errors also: the take's; not_found
/// (no frames).
[[nodiscard]] Result<std::vector<model::FeatureFrame>> take_features(const take::Take& take);

/// Names of the entries of such features: the face's IMUs, whatever else the rig has; empty: it has none.
[[nodiscard]] std::vector<std::string> traced_sensor_names(const sensor::Rig& rig);

}  // namespace mien::solve
