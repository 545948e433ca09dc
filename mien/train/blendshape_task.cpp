#include "mien/train/blendshape_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/face/profile.h"
#include "mien/study/confidence.h"
#include "mien/study/imu/watched_person.h"
#include "mien/train/assess.h"

namespace mien::train {
namespace {

using Json = nlohmann::json;

std::size_t frames_in(const study::Dataset& dataset) {
  std::size_t sum = 0;
  for (const study::Sequence& s : dataset.sequences) sum += s.frames;
  return sum;
}

Json written(const Assessment& assessment) {
  Json profiles = Json::object(), samplers = Json::array();
  for (const auto& p : assessment.profiles)
    profiles[p.name] = {{"ridge_mse", p.ridge_mse}, {"mean_pose_mse", p.mean_pose_mse}};
  for (const auto& c : assessment.samplers)
    samplers.push_back({{"steps", c.settings.steps},
                        {"first_noise", c.settings.first_noise},
                        {"hold", c.settings.hold == model::OverlapHold::clean ? "clean" : "noised"},
                        {"mse", c.mse},
                        {"jitter_ratio", c.jitter_ratio},
                        {"seam_ratio", c.seam_ratio}});
  Json results = {{"validation", {{"profiles", profiles}}}};
  if (assessment.causal)
    results["causal"] = {{"mse", assessment.causal->mse}, {"jitter_ratio", assessment.causal->jitter_ratio}};
  else
    results["samplers"] = samplers;
  return results;
}

/// Nothing where the data know no skin.
std::optional<model::Skin> skin_of(const study::Dataset& training) {
  if (training.standard_slopes.empty()) return std::nullopt;
  return model::Skin{
      .standard = training.standard_slopes, .covariance = weight_covariance_of(training), .wearer = {}};
}

}  // namespace

Result<std::unique_ptr<BlendshapeTask>> BlendshapeTask::create(Recipe recipe, study::Dataset training,
                                                               study::Dataset validation, std::string rig) {
  MIEN_TRY(check(training));
  MIEN_TRY(check(validation));
  MIEN_TRY(check_apart(training, validation));
  if (recipe.known_skin > 0)
    for (const study::Dataset* data : {&training, &validation})
      if (data->standard_slopes.size() != 3 * data->sensors.size() * face::kShapeCount ||
          std::ranges::any_of(data->sequences, [](const auto& s) { return s.slopes.empty(); }))
        return fail(ErrorCode::mismatch, "the recipe wants known skins, and the data have none", "recipe",
                    "set augmentation.known_skin to 0");
  const model::FeatureLayout layout = {.sensors = training.sensors, .presence_flags = recipe.presence_flags};
  recipe.architecture.condition = layout.width();
  recipe.architecture.outputs = face::kShapeCount;
  MIEN_TRY(model::check(recipe.architecture));
  const std::size_t window = recipe.architecture.window;
  std::unique_ptr<BlendshapeTask> task(
      new BlendshapeTask(std::move(recipe), std::move(training), std::move(validation), std::move(rig)));
  if (task->training_batches_.places() == 0 || task->validation_batches_.places() == 0)
    return fail(ErrorCode::bad_usage,
                fmt::format("training or validation has no sequence of {} frames", window));
  return task;
}

BlendshapeTask::BlendshapeTask(Recipe recipe, study::Dataset training, study::Dataset validation,
                               std::string rig)
    : recipe_(std::move(recipe)),
      training_(std::move(training)),
      validation_(std::move(validation)),
      model_{.architecture = recipe_.architecture,
             .features = {.sensors = training_.sensors, .presence_flags = recipe_.presence_flags},
             .normalisation = normalisation_of(training_, recipe_.lab_noise_rad),
             .shapes = {face::kShapeNames.begin(), face::kShapeNames.end()},
             .mean_pose = mean_pose_of(training_),
             .ridge = {},
             .skin = skin_of(training_),
             .confidence = {},
             .schedule = recipe_.schedule,
             .sampler = {},
             .rig = std::move(rig),
             .recipe = recipe_.text,
             .results = {},
             .network = {}},
      training_batches_(training_, recipe_, model_.features, model_.normalisation, model_.skin,
                        model_.mean_pose),
      validation_batches_(validation_, recipe_, model_.features, model_.normalisation, model_.skin,
                          model_.mean_pose) {}

Batch BlendshapeTask::random_batch(std::size_t count, Random random) const {
  return training_batches_.random_batch(count, random);
}

Batch BlendshapeTask::validation_batch(Random random) const {
  return validation_batches_.even_batch(recipe_.windows, random);
}

std::string BlendshapeTask::training_hash() const {
  return hash_of(training_);
}

std::string BlendshapeTask::validation_hash() const {
  return fmt::format("{} {}", hash_of(validation_), recipe_.lab_noise_rad);
}

std::size_t BlendshapeTask::training_frames() const {
  return frames_in(training_);
}

std::size_t BlendshapeTask::validation_frames() const {
  return frames_in(validation_);
}

Result<std::string> BlendshapeTask::results_of(const std::filesystem::path& model) const {
  MIEN_TRY_ASSIGN(const model::ModelFile standing, model::read_model(model));
  return standing.results;
}

Result<std::vector<model::Tensor>> BlendshapeTask::begin_with(const std::filesystem::path& model) {
  MIEN_TRY_ASSIGN(model::ModelFile standing, model::read_model(model));
  if (standing.architecture.kind != recipe_.architecture.kind ||
      model::network_tensors(standing.architecture) != model::network_tensors(recipe_.architecture) ||
      standing.features != model_.features)
    return fail(ErrorCode::mismatch, "it is a network of another size or of other sensors", model.string(),
                "start from a model of the recipe's own architecture and rig");
  model_.normalisation = standing.normalisation;
  training_batches_.use(standing.normalisation);
  validation_batches_.use(standing.normalisation);
  return std::move(standing.network);
}

Result<std::string> BlendshapeTask::assess(std::span<const model::Tensor> network, const Progress& progress) {
  model_.network.assign(network.begin(), network.end());
  MIEN_TRY_ASSIGN(const Assessment assessment,
                  train::assess(recipe_, training_batches_, validation_batches_, model_, progress));
  MIEN_TRY_ASSIGN(model_.confidence,
                  study::measure_confidence(study::watched_by(model_, validation_.sensors, "validation",
                                                              study::watched(validation_)),
                                            recipe_.seed, progress, 1));
  return written(assessment).dump();
}

Result<void> BlendshapeTask::write(const std::filesystem::path& path, const std::string& results) const {
  model::ModelFile whole = model_;
  whole.results = results;
  return model::write_model(path, whole);
}

}  // namespace mien::train
