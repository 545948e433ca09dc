#include "lab/imu/placement/placement_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lab/imu/person_errors.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/measure/metrics.h"
#include "mien/solve/part_of_work.h"

namespace mien::lab {
namespace {

constexpr double kPlacementTestsShare = 0.12;  // Of the work: who is tested on performs first.
constexpr double kPlacementTrainedShare = 0.92;

/// People of one set's rig whom nobody trained on.
struct PlacementTests {
  std::vector<std::string> sensors;
  std::vector<synthetic::ImuPerson> device, lab;
};

Result<PlacementTests> perform_tests(const PlacementTrainingRequest& request, const sensor::Rig& rig,
                                     const Progress& progress) {
  synthetic::DataRecipe recipe = request.data;
  recipe.seed = Random(request.seed).fork("placement tests").bits() >> 1U;  // As recipe_seed().
  recipe.performers = 0;
  recipe.validation_performers = static_cast<int>(request.test_people);
  recipe.seconds = recipe.device_seconds = request.test_seconds;
  recipe.device_long_share = 0;
  MIEN_TRY_ASSIGN(const dataset::TrainingData data,
                  synthetic::make_dataset(recipe, "builtin", rig, progress, request.threads));
  return PlacementTests{.sensors = data.validation.sensors,
                        .device = synthetic::watched(data.validation),
                        .lab = watched_in_lab(data.validation, request.seed)};
}

Result<void> try_people(const model::ModelFile& model, const PlacementTests& tests,
                        const std::vector<synthetic::ImuPerson>& people, const measure::Meter& meter,
                        unsigned threads, SeedErrors& errors) {
  MIEN_TRY_ASSIGN(
      const std::vector<PersonErrors> of_people,
      errors_of_people(model, tests.sensors, people, meter, synthetic::WindowJoin::overlap, threads));
  errors.add_seed(of_people);
  return {};
}

std::string percent_of(const Interval& change) {
  return fmt::format("{:+.1f} % ({:+.1f} to {:+.1f})", 100 * change.mean, 100 * change.low,
                     100 * change.high);
}

}  // namespace

Result<std::vector<TrainedPlacement>> train_placements(const PlacementTrainingRequest& request,
                                                       std::span<const PlacementRig> rigs,
                                                       const TrainShort& train, const Progress& progress) {
  const auto count = static_cast<double>(rigs.size());
  std::vector<PlacementTests> tests;
  for (std::size_t r = 0; r < rigs.size(); ++r) {
    const double from = kPlacementTestsShare * static_cast<double>(r) / count;
    MIEN_TRY_ASSIGN(tests.emplace_back(),
                    perform_tests(request, rigs[r].rig,
                                  solve::part_of_work(progress, from, from + kPlacementTestsShare / count)));
  }
  std::vector<ShortTraining> trainings;
  for (const PlacementRig& worn : rigs) {
    const std::string rig_text = sensor::write_rig(worn.rig);
    for (std::size_t s = 0; s < request.seeds; ++s)
      trainings.push_back(
          {.name = fmt::format("{}-{}", worn.name, s + 1),
           .recipe =
               short_recipe({.seed = training_seed(request.seed, s), .steps = request.steps}, request.data),
           .rig = rig_text,
           .data_key =
               fmt::format("placement\n{}long {} moving {}\n{}", data_table(request.data),
                           request.data.device_long_share, request.data.device_moving_share, rig_text),
           .data = [&request, &worn](const Progress& part) {
             return synthetic::make_dataset(request.data, "builtin", worn.rig, part, request.threads);
           }});
  }
  MIEN_TRY_ASSIGN(
      const std::vector<ShortTrained> trained,
      train(trainings, solve::part_of_work(progress, kPlacementTestsShare, kPlacementTrainedShare)));

  const measure::Meter meter(builtin_face::default_builtin());
  std::vector<TrainedPlacement> out;
  for (std::size_t r = 0; r < rigs.size(); ++r) {
    TrainedPlacement& row = out.emplace_back();
    row.name = rigs[r].name;
    row.title = rigs[r].title;
    row.sensors = rigs[r].rig.face_sensors().size();
    for (std::size_t s = 0; s < request.seeds; ++s) {
      const double done = static_cast<double>(r * request.seeds + s) / static_cast<double>(trained.size());
      if (!progress(kPlacementTrainedShare + (1 - kPlacementTrainedShare) * done, row.title))
        return fail(ErrorCode::cancelled, "stopped", "study placement");
      const model::ModelFile& model = trained[r * request.seeds + s].model;
      MIEN_TRY(try_people(model, tests[r], tests[r].device, meter, request.threads, row.device));
      MIEN_TRY(try_people(model, tests[r], tests[r].lab, meter, request.threads, row.lab));
    }
  }
  return out;
}

std::string PlacementContest::verdict() const {
  const std::string figures =
      fmt::format("vertex error {} in device, {} in lab; squared error {} and {}", percent_of(device),
                  percent_of(lab), percent_of(device_mse), percent_of(lab_mse));
  if (device.high < 0) return fmt::format("By vertex error {} beats {}: {}.", ours, paper, figures);
  if (device.low > 0)
    return fmt::format("By vertex error {} beats {}, from which {} differs by: {}.", paper, ours, ours,
                       figures);
  return fmt::format("By vertex error neither {} nor {} is better with 95 % confidence: {}.", ours, paper,
                     figures);
}

PlacementContest contest(const TrainedPlacement& ours, const TrainedPlacement& paper) {
  return {.ours = ours.title,
          .paper = paper.title,
          .device = change_interval(ours.device.pve_mm, paper.device.pve_mm),
          .lab = change_interval(ours.lab.pve_mm, paper.lab.pve_mm),
          .device_mse = change_interval(ours.device.mse, paper.device.mse),
          .lab_mse = change_interval(ours.lab.mse, paper.lab.mse)};
}

}  // namespace mien::lab
