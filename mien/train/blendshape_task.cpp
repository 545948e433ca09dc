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

double takes_share_of(const Recipe& recipe) {
  return recipe.takes_share.value_or(0);
}

TaskData training_data_of(const dataset::Dataset& training, const Recipe& recipe) {
  const double share = takes_share_of(recipe);
  const std::string hash = hash_of(training);
  return {.hash = share > 0 ? fmt::format("{} {}", hash, share) : hash, .frames = frames_in(training)};
}

TaskData validation_data_of(const dataset::Dataset& validation, const Recipe& recipe) {
  std::string hash = fmt::format("{} {}", hash_of(validation), recipe.lab_noise_rad);
  if (any_of_takes(validation)) hash += fmt::format(" {}", takes_share_of(recipe));
  return {.hash = std::move(hash), .frames = frames_in(validation)};
}

/// What is known of a model before its network is.
model::ModelFile model_around(const Recipe& recipe, const dataset::Dataset& training, std::string rig) {
  const FrameWeights weights = as_drawn(training, takes_share_of(recipe));
  model::ModelFile model;
  model.features = {.sensors = training.sensors, .presence_flags = recipe.presence_flags};
  model.normalisation = normalisation_of(training, recipe.lab_noise_rad, weights);
  model.shapes = {face::kShapeNames.begin(), face::kShapeNames.end()};
  model.mean_pose = mean_pose_of(training, weights);
  model.skin = skin_of(training, weights);
  model.schedule = recipe.schedule;
  model.rig = std::move(rig);
  return model;
}

/// Features of IMUs to blendshape weights.
class BlendshapeTask final : public FileTask<model::ModelFile, model::read_model, model::write_model> {
 public:
  BlendshapeTask(const Recipe& recipe, dataset::Dataset training, dataset::Dataset validation,
                 std::string rig, bool one_person)
      : FileTask(recipe, training_data_of(training, recipe), validation_data_of(validation, recipe),
                 model_around(recipe, training, std::move(rig))),
        training_(std::move(training)),
        validation_(std::move(validation)),
        one_person_(one_person),
        training_batches_(batches_of(training_)),
        validation_batches_(batches_of(validation_)) {}

  [[nodiscard]] Result<void> check_places() const {
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

  [[nodiscard]] Batch random_batch(std::size_t count, Random random) const override {
    return training_batches_.random_batch(count, random);
  }

  /// Of virtual performers, where there are any to validate on; else of takes.
  [[nodiscard]] Batch validation_batch(Random random) const override {
    return std::move(validation_parts(random).front().windows);
  }

  /// Of virtual performers and of takes, by the recipe's share.
  [[nodiscard]] std::vector<ValidationPart> validation_parts(Random random) const override {
    // Few people may be held out, so the share is one of the score, whatever windows they have.
    const double share = validation_batches_.places(WindowsOf::takes) > 0 ? takes_share() : 0;
    const auto takes_windows =
        static_cast<std::size_t>(std::round(share * static_cast<double>(recipe_.windows)));
    std::vector<ValidationPart> parts;
    if (share < 1)
      parts.push_back({.name = "virtual",
                       .share = 1 - share,
                       .windows = validation_batches_.even_batch(
                           std::max<std::size_t>(recipe_.windows - takes_windows, 1), random,
                           WindowsOf::virtual_performers)});
    if (share > 0)
      parts.push_back({.name = "takes",
                       .share = share,
                       .windows = validation_batches_.even_batch(std::max<std::size_t>(takes_windows, 1),
                                                                 random.fork("takes"), WindowsOf::takes)});
    return parts;
  }

  /// Takes over the standard skin too, where the data know none.
  [[nodiscard]] Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) override {
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

  [[nodiscard]] Result<std::string> assess(std::span<const model::Tensor> network,
                                           const Progress& progress) override {
    model_.network.assign(network.begin(), network.end());
    MIEN_TRY_ASSIGN(const Assessment assessment,
                    train::assess(recipe_, training_batches_, validation_batches_, model_, progress));
    MIEN_TRY_ASSIGN(model_.confidence, synthetic::measure_confidence(
                                           synthetic::watched_by(model_, validation_.sensors, "validation",
                                                                 synthetic::watched(validation_)),
                                           recipe_.seed, progress, 1));
    Json results = written(assessment);
    if (takes_share() > 0)
      results["takes"] = told_of_takes(training_, validation_, takes_share(), one_person_);
    return results.dump();
  }

 private:
  [[nodiscard]] double takes_share() const { return takes_share_of(recipe_); }
  [[nodiscard]] BatchMaker batches_of(const dataset::Dataset& dataset) const {
    return {dataset, recipe_, model_.features, model_.normalisation, model_.skin, model_.mean_pose};
  }

  dataset::Dataset training_;
  dataset::Dataset validation_;
  bool one_person_ = false;
  BatchMaker training_batches_;
  BatchMaker validation_batches_;
};

}  // namespace

Result<std::unique_ptr<Task>> make_blendshape_task(Recipe recipe, dataset::Dataset training,
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
  auto task = std::make_unique<BlendshapeTask>(recipe, std::move(training), std::move(validation),
                                               std::move(rig), one_person);
  MIEN_TRY(task->check_places());
  return task;
}

}  // namespace mien::train
