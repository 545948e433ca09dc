#include "lab/imu/settings_study.h"

#include <algorithm>
#include <utility>

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

}  // namespace mien::lab
