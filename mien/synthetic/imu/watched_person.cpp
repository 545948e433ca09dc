#include "mien/synthetic/imu/watched_person.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "mien/core/draw_first.h"
#include "mien/solve/trace_features.h"
#include "mien/synthetic/imu/make_dataset.h"
#include "mien/synthetic/shifted_person.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/frame_writer.h"
#include "mien/tracker/window_solver.h"
#include "mien/virtual/performers.h"

namespace mien::synthetic {
namespace {

ImuPerson watched(const dataset::Sequence& sequence, std::size_t sensors) {
  ImuPerson out;
  for (std::size_t f = 0; f < sequence.frames; ++f) {
    model::FeatureFrame& frame = out.features.emplace_back();
    frame.time = DeviceTime(frame_offset(static_cast<std::int64_t>(f)));
    frame.sensors.resize(sensors);
    const float* values = sequence.values.data() + f * 7 * sensors;
    const std::uint8_t* present = sequence.present.data() + f * 2 * sensors;
    for (std::size_t s = 0; s < sensors; ++s) {
      model::SensorFeature& sensor = frame.sensors[s];
      sensor.accel_m_s2 = {values[7 * s], values[7 * s + 1], values[7 * s + 2]};
      std::copy_n(values + 7 * s + 3, 4, sensor.rotation.begin());
      sensor.has_rotation = present[s] != 0;
      sensor.has_accel = present[sensors + s] != 0;
    }
    std::copy_n(sequence.weights.begin() + static_cast<std::ptrdiff_t>(f * face::kShapeCount),
                face::kShapeCount, out.truth.emplace_back().values.begin());
  }
  return out;
}

/// Coverage of each shape, frame by frame.
std::vector<tracker::Coverage> coverage(const model::ModelFile& model,
                                        const std::vector<std::string>& sensors,
                                        const std::vector<model::FeatureFrame>& features) {
  const tracker::FrameWriter writer(model);
  tracker::ModelInput input(model, sensors);
  std::vector<float> condition(model.features.width());
  std::vector<tracker::Coverage> out;
  out.reserve(features.size());
  for (const model::FeatureFrame& frame : features) {
    input.encode(frame, condition);
    out.push_back(writer.coverage(input));
  }
  return out;
}

class WatchedByModel final : public WatchedPerson {
 public:
  WatchedByModel(std::shared_ptr<const model::ModelFile> model, std::vector<std::string> sensors,
                 ImuPerson person)
      : model_(std::move(model)), sensors_(std::move(sensors)), person_(std::move(person)) {}
  [[nodiscard]] std::size_t sensor_count() const override { return sensors_.size(); }
  [[nodiscard]] Result<Watched> watch(std::size_t lost, const Random& random) const override {
    const std::vector<model::FeatureFrame> features = without_sensors(person_.features, lost, random);
    MIEN_TRY_ASSIGN(std::vector<face::BlendshapeWeights> answer, answers_of(*model_, sensors_, features));
    return Watched{std::move(answer), coverage(*model_, sensors_, features), person_.truth};
  }

 private:
  std::shared_ptr<const model::ModelFile> model_;
  std::vector<std::string> sensors_;  // Names of the features' entries.
  ImuPerson person_;
};

}  // namespace

Result<std::vector<face::BlendshapeWeights>> answers_of(const model::ModelFile& model,
                                                        const std::vector<std::string>& sensors,
                                                        std::span<const model::FeatureFrame> features,
                                                        WindowJoin join) {
  std::vector<face::BlendshapeWeights> out;
  out.reserve(features.size());
  if (model.architecture.kind == model::NetworkKind::window) {
    MIEN_TRY_ASSIGN(const tracker::WindowSolver solver, tracker::WindowSolver::create(model));
    const std::size_t together =
        join == WindowJoin::overlap ? features.size() : model.architecture.window;  // Frames.
    for (std::size_t begin = 0; begin < features.size(); begin += together) {
      MIEN_TRY_ASSIGN(const std::vector<face::OutputFrame> frames,
                      solver.solve(features.subspan(begin, std::min(together, features.size() - begin)),
                                   sensors, model.sampler, no_progress));
      for (const face::OutputFrame& frame : frames) out.push_back(frame.weights);
    }
    return out;
  }
  MIEN_TRY_ASSIGN(tracker::CausalTracker tracker, tracker::CausalTracker::create(model, sensors));
  face::OutputFrame frame;
  for (const model::FeatureFrame& one : features) {
    tracker.step(one, frame);
    out.push_back(frame.weights);
  }
  return out;
}

std::vector<ImuPerson> watched(const dataset::Dataset& data) {
  const bool device = std::ranges::any_of(data.sequences, [](const dataset::Sequence& s) { return !s.lab; });
  std::vector<ImuPerson> out;
  for (const dataset::Sequence& sequence : data.sequences)
    if (sequence.lab != device) out.push_back(watched(sequence, data.sensors.size()));
  return out;
}

Result<std::vector<ImuPerson>> watch_virtual(int people, double seconds, std::uint64_t seed,
                                             const sensor::Rig& rig, const Progress& progress,
                                             unsigned threads) {
  DataRecipe recipe;
  recipe.seed = seed;
  recipe.performers = people;
  recipe.validation_performers = 0;
  recipe.seconds = 0;
  recipe.device_seconds = seconds;
  MIEN_TRY_ASSIGN(const dataset::TrainingData data, make_dataset(recipe, "builtin", rig, progress, threads));
  return watched(data.train);
}

Result<std::vector<ImuPerson>> watch_shifted(int people, double seconds, std::uint64_t seed,
                                             const sensor::Rig& rig, const Progress& progress,
                                             unsigned threads) {
  std::vector<ImuPerson> out(static_cast<std::size_t>(people));
  MIEN_TRY(virt::for_each_performer(out.size(), threads, progress, [&](std::size_t p) -> Result<void> {
    const Random root = Random(seed).fork("shifted", p);
    const ShiftedPerson person = draw_shifted_person(p, seconds, root);
    MIEN_TRY_ASSIGN(out[p], watch_recorded(person.motion, person.face, rig, root.fork("devices")));
    return {};
  }));
  return out;
}

Result<ImuPerson> watch_recorded(const face::Motion& motion, const face::Face& face, const sensor::Rig& rig,
                                 const Random& random) {
  MIEN_TRY_ASSIGN(const virt::DeviceFaults faults, virt::parse_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const virt::Performance played,
                  virt::perform_with({.faults = faults}, face, motion, rig, random));
  const virt::VirtualSession& session = played.session;
  MIEN_TRY_ASSIGN(std::vector<model::FeatureFrame> features,
                  solve::trace_features(rig, session.events, session.entries, session.ticks));
  return evaluated_frames(std::move(features), session.truth);
}

ImuPerson evaluated_frames(std::vector<model::FeatureFrame> features,
                           const std::vector<take::TruthFrame>& truth) {
  ImuPerson out;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (!truth[f].evaluated || !truth[f].has_face) continue;
    out.features.push_back(std::move(features[f]));
    face::BlendshapeWeights& weights = out.truth.emplace_back();
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      weights[k] = std::clamp(truth[f].weights[k], 0.0F, 1.0F);
  }
  return out;
}

std::vector<model::FeatureFrame> without_sensors(std::span<const model::FeatureFrame> features,
                                                 std::size_t lost, Random random) {
  std::vector<model::FeatureFrame> out(features.begin(), features.end());
  if (out.empty()) return out;
  std::vector<std::size_t> order(out.front().sensors.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  draw_first(std::span(order), lost, random);
  for (std::size_t i = 0; i < std::min(lost, order.size()); ++i)
    for (model::FeatureFrame& frame : out) frame.sensors[order[i]] = {};
  return out;
}

WatchedGroup watched_by(const model::ModelFile& model, const std::vector<std::string>& sensors,
                        std::string who, std::vector<ImuPerson> people) {
  return watched_by(std::make_shared<const model::ModelFile>(model), sensors, std::move(who),
                    std::move(people));
}

WatchedGroup watched_by(std::shared_ptr<const model::ModelFile> model,
                        const std::vector<std::string>& sensors, std::string who,
                        std::vector<ImuPerson> people) {
  WatchedGroup group{std::move(who), {}};
  for (ImuPerson& person : people)
    group.people.push_back(std::make_shared<const WatchedByModel>(model, sensors, std::move(person)));
  return group;
}

}  // namespace mien::synthetic
