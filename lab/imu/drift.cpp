#include "lab/imu/drift.h"

#include <algorithm>
#include <cmath>

#include "mien/core/units.h"
#include "mien/solve/trace_features.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

/// Squared errors of one performer under one setting, rad^2.
struct DriftSums {
  double squares = 0, vertical = 0, count = 0, missing = 0;

  DriftSums& operator+=(const DriftSums& other) {
    squares += other.squares;
    vertical += other.vertical;
    count += other.count;
    missing += other.missing;
    return *this;
  }
};

double rms_deg(double squares, double count) {
  return count > 0 ? kDegPerRad * std::sqrt(squares / count) : 0;
}

Result<DriftSums> compare(const sensor::Rig& rig, const std::vector<virt::SkinSite>& sites,
                          const virt::VirtualSession& session, const imu::DriftSettings& drift) {
  imu::PipelineSettings settings;
  settings.drift = drift;
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> frames,
                  solve::trace_features(rig, session.events, session.entries, session.ticks, settings));
  const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
  DriftSums sums;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (!session.truth[f].evaluated) continue;
    for (std::size_t i = 0; i < face_sensors.size(); ++i) {
      const model::SensorFeature& sensor = frames[f].sensors[i];
      if (!sensor.has_rotation) {
        ++sums.missing;
        continue;
      }
      const auto& [w, x, y, z] = sensor.rotation;
      const Quat truth = sites[face_sensors[i]].rotation(session.truth[f].weights);
      const Vec3 error = log_rotation(Quat(w, x, y, z) * truth.conjugate());
      sums.squares += error.squaredNorm();
      sums.vertical += error.y() * error.y();
      ++sums.count;
    }
  }
  return sums;
}

Result<std::vector<DriftSums>> perform_one(const DriftRequest& request, const sensor::Rig& rig,
                                           const virt::DeviceFaults& faults,
                                           std::span<const imu::DriftSettings> settings,
                                           std::size_t performer) {
  const Random root = Random(request.seed).fork("drift", performer);
  const virt::VirtualPerson person = virt::draw_person(root);
  MIEN_TRY_ASSIGN(const virt::Performance performance,
                  virt::perform_with({.faults = faults}, person.face,
                                     virt::draw_motion(request.seconds, person.style, root), rig, root));
  std::vector<DriftSums> sums;
  for (const imu::DriftSettings& drift : settings) {
    MIEN_TRY_ASSIGN(sums.emplace_back(), compare(rig, performance.sites, performance.session, drift));
  }
  return sums;
}

}  // namespace

Result<std::vector<Drift>> study_drift(const DriftRequest& request, const sensor::Rig& rig,
                                       std::span<const imu::DriftSettings> settings,
                                       const Progress& progress) {
  MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  const auto count = static_cast<std::size_t>(std::max(request.performers, 1));
  std::vector<std::vector<DriftSums>> sums(count);
  MIEN_TRY(virt::for_each_performer(count, request.threads, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(sums[p], perform_one(request, rig, faults, settings, p));
    return {};
  }));

  std::vector<Drift> drifts;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    DriftSums all;
    Drift drift{.settings = settings[i]};
    for (const std::vector<DriftSums>& one : sums) {
      all += one[i];
      drift.performer_rms_deg.push_back(rms_deg(one[i].squares, one[i].count));
    }
    std::ranges::sort(drift.performer_rms_deg);
    drift.rms_deg = rms_deg(all.squares, all.count);
    drift.vertical_rms_deg = rms_deg(all.vertical, all.count);
    drift.missing = all.missing / std::max(1.0, all.missing + all.count);
    drifts.push_back(drift);
  }
  return drifts;
}

}  // namespace mien::lab
