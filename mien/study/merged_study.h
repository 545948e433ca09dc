#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/eyewear/marker_network.h"
#include "mien/measure/metrics.h"
#include "mien/model/model_file.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/rig.h"
#include "mien/shaping/merge_settings.h"
#include "mien/study/confidence.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/imu/device_faults.h"

namespace mien::study {

/// Virtual people who wear IMUs and glasses at once.
struct MergedRequest {
  int performers = 3;
  double seconds = 60;  ///< Each one's performance, after the prologue.
  performer::PrologueKind prologue = performer::PrologueKind::full;
  /// IMUs of the face, drawn for each person, from which nothing comes once the performance has begun; 0 to
  /// all.
  int lost = 0;
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
  shaping::MergeSettings merge;
};

/// What is worn, and who answers.
struct MergedScene {
  sensor::Rig rig;  ///< Of IMUs and glasses; the frame grid is an IMU's.
  virt::DeviceFaults imu_faults;
  virt::EyewearFaults eyewear_faults;
  model::ModelFile imu;  ///< A causal model.
  eyewear::MarkerNetworkFile eyewear;
  builtin_face::MarkerSet markers;
};

/// One person's minute, answered three times from one session.
struct MergedPerson {
  measure::Metrics imu;                                ///< By the IMUs alone.
  measure::Metrics eyewear;                            ///< By the glasses alone.
  measure::Metrics merged;                             ///< By shaping::Merge of both.
  std::array<double, face::kShapeCount> by_eyewear{};  ///< Share of the frames that the glasses answered.
  Reliability confidence;                              ///< Of the merged frames.
  double hand_overs = 0;  ///< How often a shape changed hands, a second of performance, all shapes together.

  /// Mean absolute error of the 53 weights.
  [[nodiscard]] static double mae(const measure::Metrics& metrics);
};

/// What merging loses or gains: each person performs once, IMUs and glasses of the scene's rig feel it at
/// once and are received in one session, and the trackers' frames are merged as a live session's are. The
/// prologue (ten seconds of neutral, nod, shake, and expressions in a full one) calibrates both. Errors:
/// bad_usage (nobody; more lost than there are; a rig whose grid is not an IMU's), those of the devices and
/// the models; cancelled. Cost: about half a minute of one core a person and minute.
[[nodiscard]] Result<std::vector<MergedPerson>> study_merged(const MergedRequest& request,
                                                             const MergedScene& scene,
                                                             const Progress& progress);

}  // namespace mien::study
