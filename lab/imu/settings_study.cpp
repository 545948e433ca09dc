#include "lab/imu/settings_study.h"

#include <algorithm>
#include <cmath>

#include "lab/imu/observed_rotations.h"
#include "mien/core/units.h"
#include "mien/measure/evaluation.h"
#include "mien/model/schedule.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/solve/trace_features.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/model_input.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using Answers = std::vector<face::BlendshapeWeights>;

/// The network's answers to a whole session, unfiltered.
Answers answers_to(std::span<const model::FeatureFrame> features, const model::ModelFile& model,
                   const model::CausalNetwork& network, const sensor::Rig& rig) {
  tracker::ModelInput input(model, rig.face_sensor_names());
  model::CausalNetwork::State state(network);
  std::vector<float> condition(model.features.width());
  Answers out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    input.encode(features[f], condition);
    network.step(condition, state, out[f].values);
    std::ranges::transform(out[f].values, out[f].values.begin(), model::from_network);
  }
  return out;
}

Answers filtered(Answers answers, const std::optional<tracker::JitterSettings>& settings) {
  if (!settings) return answers;
  tracker::JitterFilter filter(*settings);
  for (face::BlendshapeWeights& answer : answers) filter.apply(answer);
  return answers;
}

/// One person's metrics, a filter each.
using PersonMetrics = std::vector<measure::Metrics>;

Result<PersonMetrics> try_filters(bool lab, const virt::VirtualPerson& person, const face::Motion& motion,
                                  const sensor::Rig& rig, const model::ModelFile& model,
                                  const model::CausalNetwork& network,
                                  std::span<const std::optional<tracker::JitterSettings>> filters,
                                  const Random& root) {
  MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const virt::Performance performance,
                  virt::perform_with({.faults = faults, .lab = lab}, person.face, motion, rig, root));
  const virt::VirtualSession& session = performance.session;
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features,
                  solve::trace_features(rig, session.events, session.entries, session.ticks));
  const Answers answers = answers_to(features, model, network, rig);
  const measure::Meter meter(person.face);
  PersonMetrics out;
  for (const std::optional<tracker::JitterSettings>& filter : filters)
    out.push_back(measure::measure_track(meter, session.truth, filtered(answers, filter)));
  return out;
}

FilteredFigures mean_over(std::span<const PersonMetrics> people, std::size_t filter) {
  FilteredFigures out;
  double blinking = 0;
  for (const PersonMetrics& person : people) {
    const measure::Metrics& one = person[filter];
    const auto share = 1 / static_cast<double>(people.size());
    out.mse += share * one.mse;
    out.pve_mm += share * one.pve_mm.mean;
    out.jitter_ratio += share * one.jitter_ratio.value_or(0);
    out.blink_f1 += one.blink_f1.value_or(0);
    blinking += one.blink_f1 ? 1 : 0;
  }
  out.blink_f1 /= std::max(1.0, blinking);
  return out;
}

/// Squared errors of one performer under one setting, rad^2.
struct DriftSums {
  double squares = 0, vertical = 0, count = 0;

  DriftSums& operator+=(const DriftSums& other) {
    squares += other.squares;
    vertical += other.vertical;
    count += other.count;
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
      if (!sensor.has_rotation) continue;
      const Vec3 error = rotation_error(sensor, sites[face_sensors[i]].rotation(session.truth[f].weights));
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

Result<std::vector<JitterTrial>> study_jitter(const JitterRequest& request, const sensor::Rig& rig,
                                              const model::ModelFile& model,
                                              std::span<const std::optional<tracker::JitterSettings>> filters,
                                              const Progress& progress) {
  if (request.performers < 1) return fail(ErrorCode::bad_usage, "nobody performs", "settings study");
  MIEN_TRY(tracker::CausalTracker::create(model, rig.face_sensor_names()));
  MIEN_TRY_ASSIGN(const model::CausalNetwork network,
                  model::CausalNetwork::create(model.architecture, model.network, tracker::kLivePrecision));
  const auto count = static_cast<std::size_t>(request.performers);
  std::vector<PersonMetrics> device(count), lab(count);
  MIEN_TRY(virt::for_each_performer(count, request.threads, progress, [&](std::size_t p) -> Result<void> {
    const Random root = Random(request.seed).fork("settings", p);
    const virt::VirtualPerson person = virt::draw_person(root);
    const face::Motion motion =
        performer::perform(performer::default_script(performer::Block::mixed, request.seconds), person.style,
                           root.fork("motion"));
    MIEN_TRY_ASSIGN(device[p], try_filters(false, person, motion, rig, model, network, filters, root));
    MIEN_TRY_ASSIGN(lab[p], try_filters(true, person, motion, rig, model, network, filters, root));
    return {};
  }));
  std::vector<JitterTrial> out;
  for (std::size_t i = 0; i < filters.size(); ++i)
    out.push_back({filters[i], mean_over(device, i), mean_over(lab, i)});
  return out;
}

std::optional<std::size_t> best_filter(std::span<const JitterTrial> trials, double limit) {
  std::optional<std::size_t> best;
  const auto error = [](const JitterTrial& trial) { return trial.device.pve_mm + trial.lab.pve_mm; };
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (trials[i].device.jitter_ratio > limit || trials[i].lab.jitter_ratio > limit) continue;
    if (!best || error(trials[i]) < error(trials[*best])) best = i;
  }
  return best;
}

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
    for (const std::vector<DriftSums>& one : sums) all += one[i];
    drift.rms_deg = rms_deg(all.squares, all.count);
    drift.vertical_rms_deg = rms_deg(all.vertical, all.count);
    drifts.push_back(drift);
  }
  return drifts;
}

}  // namespace mien::lab
