#include "mien/train/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/dataset/dataset.h"
#include "mien/face/profile.h"
#include "mien/model/model_file.h"
#include "mien/synthetic/confidence.h"
#include "mien/synthetic/imu/watched_person.h"
#include "mien/train/assess.h"

namespace mien::train {
namespace {

using Json = nlohmann::json;

std::size_t frames_in(const dataset::Dataset& dataset) {
  std::size_t sum = 0;
  for (const dataset::Sequence& s : dataset.sequences) sum += s.frames;
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
std::optional<model::Skin> skin_of(const dataset::Dataset& training, const FrameWeights& weights) {
  if (training.standard_slopes.empty()) return std::nullopt;
  return model::Skin{.standard = training.standard_slopes,
                     .covariance = weight_covariance_of(training, weights),
                     .wearer = {}};
}

bool any_of_takes(const dataset::Dataset& dataset) {
  return std::ranges::any_of(dataset.sequences, &dataset::Sequence::from_take);
}

bool any_of_performers(const dataset::Dataset& dataset) {
  return !std::ranges::all_of(dataset.sequences, &dataset::Sequence::from_take);
}

/// Whether every performer's skin is known; people's is not, and their takes are read as they are.
bool knows_skins(const dataset::Dataset& data) {
  return !any_of_performers(data) ||
         (data.standard_slopes.size() == 3 * data.sensors.size() * face::kShapeCount &&
          std::ranges::none_of(data.sequences,
                               [](const auto& s) { return !s.from_take && s.slopes.empty(); }));
}

/// What may be told of people: how many, how much, and a hash by which the same takes are known again.
Json told_of_takes(const dataset::Dataset& training, const dataset::Dataset& validation, double share,
                   bool one_person) {
  const TakesAmount trained = takes_in(training), held_out = takes_in(validation);
  return {{"share", share},
          {"people", trained.people},
          {"minutes", trained.minutes},
          {"validation_people", one_person ? 0 : held_out.people},
          {"validation_minutes", held_out.minutes},
          {"one_person", one_person},
          {"hash", hash_of_takes(training, validation)}};
}

}  // namespace

/// Features of IMUs to blendshape weights: models of model::ModelFile, of either kind of network.
class BlendshapeTask final : public Task {
 public:
  [[nodiscard]] static Result<std::unique_ptr<BlendshapeTask>> create(Recipe recipe,
                                                                      dataset::Dataset training,
                                                                      dataset::Dataset validation,
                                                                      std::string rig, bool one_person);

  [[nodiscard]] const Recipe& recipe() const override { return recipe_; }
  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override;
  /// Of virtual performers, where there are any to validate on; else of takes.
  [[nodiscard]] Batch validation_batch(Random random) const override;
  /// Of virtual performers and of takes, by the recipe's share.
  [[nodiscard]] std::vector<ValidationPart> validation_parts(Random random) const override;
  [[nodiscard]] std::string training_hash() const override;
  [[nodiscard]] std::string validation_hash() const override;
  [[nodiscard]] std::size_t training_frames() const override;
  [[nodiscard]] std::size_t validation_frames() const override;
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override;
  /// Takes over the standard skin too, where the data know none.
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override;
  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override;
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override;

 private:
  BlendshapeTask(Recipe recipe, dataset::Dataset training, dataset::Dataset validation, std::string rig,
                 bool one_person);
  [[nodiscard]] Result<void> check_places() const;
  [[nodiscard]] double takes_share() const { return recipe_.takes_share.value_or(0); }

  Recipe recipe_;
  dataset::Dataset training_;
  dataset::Dataset validation_;
  bool one_person_ = false;
  FrameWeights frame_weights_;  ///< Of training.
  model::ModelFile model_;
  BatchMaker training_batches_;
  BatchMaker validation_batches_;
};

Result<std::unique_ptr<BlendshapeTask>> BlendshapeTask::create(Recipe recipe, dataset::Dataset training,
                                                               dataset::Dataset validation, std::string rig,
                                                               bool one_person) {
  MIEN_TRY(check(training));
  MIEN_TRY(check(validation));
  MIEN_TRY(check_apart(training, validation));
  if (recipe.known_skin > 0 && !(knows_skins(training) && knows_skins(validation)))
    return fail(ErrorCode::mismatch, "the recipe wants known skins, and the data have none", "recipe",
                "set augmentation.known_skin to 0");
  if (any_of_takes(training) && !recipe.takes_share)
    recipe.takes_share = any_of_performers(training) ? kUsualTakesShare : 1;
  const model::FeatureLayout layout = {.sensors = training.sensors, .presence_flags = recipe.presence_flags};
  recipe.architecture.condition = layout.width();
  recipe.architecture.outputs = face::kShapeCount;
  MIEN_TRY(model::check(recipe.architecture));
  std::unique_ptr<BlendshapeTask> task(new BlendshapeTask(std::move(recipe), std::move(training),
                                                          std::move(validation), std::move(rig), one_person));
  MIEN_TRY(task->check_places());
  return task;
}

Result<void> BlendshapeTask::check_places() const {
  const std::size_t window = recipe_.architecture.window;
  if (takes_share() == 1 && validation_batches_.places(WindowsOf::takes) == 0)
    return fail(ErrorCode::bad_usage,
                fmt::format("no take of another person has {} frames in a row to validate on", window),
                "takes",
                "hold somebody out with --splits, or train on virtual performers too: takes.share below 1");
  if ((takes_share() > 0 && training_batches_.places(WindowsOf::takes) == 0) ||
      (takes_share() < 1 && (training_batches_.places(WindowsOf::virtual_performers) == 0 ||
                             validation_batches_.places(WindowsOf::virtual_performers) == 0)))
    return fail(ErrorCode::bad_usage,
                fmt::format("training or validation has no sequence of {} frames", window));
  return {};
}

BlendshapeTask::BlendshapeTask(Recipe recipe, dataset::Dataset training, dataset::Dataset validation,
                               std::string rig, bool one_person)
    : recipe_(std::move(recipe)),
      training_(std::move(training)),
      validation_(std::move(validation)),
      one_person_(one_person),
      frame_weights_(as_drawn(training_, takes_share())),
      model_{.architecture = recipe_.architecture,
             .features = {.sensors = training_.sensors, .presence_flags = recipe_.presence_flags},
             .normalisation = normalisation_of(training_, recipe_.lab_noise_rad, frame_weights_),
             .shapes = {face::kShapeNames.begin(), face::kShapeNames.end()},
             .mean_pose = mean_pose_of(training_, frame_weights_),
             .ridge = {},
             .skin = skin_of(training_, frame_weights_),
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
  return std::move(validation_parts(random).front().windows);
}

std::vector<ValidationPart> BlendshapeTask::validation_parts(Random random) const {
  // Few people may be held out, so the share is one of the score, whatever windows they have.
  const double share = validation_batches_.places(WindowsOf::takes) > 0 ? takes_share() : 0;
  const auto takes_windows =
      static_cast<std::size_t>(std::round(share * static_cast<double>(recipe_.windows)));
  std::vector<ValidationPart> parts;
  if (share < 1)
    parts.push_back(
        {.name = "virtual",
         .share = 1 - share,
         .windows = validation_batches_.even_batch(std::max<std::size_t>(recipe_.windows - takes_windows, 1),
                                                   random, WindowsOf::virtual_performers)});
  if (share > 0)
    parts.push_back({.name = "takes",
                     .share = share,
                     .windows = validation_batches_.even_batch(std::max<std::size_t>(takes_windows, 1),
                                                               random.fork("takes"), WindowsOf::takes)});
  return parts;
}

std::string BlendshapeTask::training_hash() const {
  const std::string hash = hash_of(training_);
  return takes_share() > 0 ? fmt::format("{} {}", hash, takes_share()) : hash;
}

std::string BlendshapeTask::validation_hash() const {
  std::string text = fmt::format("{} {}", hash_of(validation_), recipe_.lab_noise_rad);
  if (any_of_takes(validation_)) text += fmt::format(" {}", takes_share());
  return text;
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
  // Takes tell of nobody's skin; those of the network's first training were brought to this one.
  if (!model_.skin && standing.skin) {
    model_.skin = std::move(standing.skin);
    model_.skin->wearer.clear();
  }
  training_batches_.use(standing.normalisation);
  validation_batches_.use(standing.normalisation);
  return std::move(standing.network);
}

Result<std::string> BlendshapeTask::assess(std::span<const model::Tensor> network, const Progress& progress) {
  model_.network.assign(network.begin(), network.end());
  MIEN_TRY_ASSIGN(const Assessment assessment,
                  train::assess(recipe_, training_batches_, validation_batches_, model_, progress));
  MIEN_TRY_ASSIGN(model_.confidence, synthetic::measure_confidence(
                                         synthetic::watched_by(model_, validation_.sensors, "validation",
                                                               synthetic::watched(validation_)),
                                         recipe_.seed, progress, 1));
  Json results = written(assessment);
  if (takes_share() > 0) results["takes"] = told_of_takes(training_, validation_, takes_share(), one_person_);
  return results.dump();
}

Result<void> BlendshapeTask::write(const std::filesystem::path& path, const std::string& results) const {
  model::ModelFile whole = model_;
  whole.results = results;
  return model::write_model(path, whole);
}

Result<std::unique_ptr<Task>> make_blendshape_task(Recipe recipe, dataset::Dataset training,
                                                   dataset::Dataset validation, std::string rig,
                                                   bool one_person) {
  return BlendshapeTask::create(std::move(recipe), std::move(training), std::move(validation), std::move(rig),
                                one_person);
}

}  // namespace mien::train
