#include "mien/train/make_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ranges>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/files.h"
#include "mien/dataset/training_takes.h"
#include "mien/sensor/rig_part.h"
#include "mien/synthetic/eyewear/eyewear_dataset.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/synthetic/imu/dataset_file.h"
#include "mien/synthetic/imu/dataset_part.h"
#include "mien/synthetic/imu/make_dataset.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/train/takes_mix.h"
#include "mien/train/tasks.h"

namespace mien::train {
namespace {

using MadeTask = Result<std::unique_ptr<Task>>;

std::string amount_text(const TakesAmount& amount) {
  if (amount.people == 0) return "nothing";
  return fmt::format("{:.1f} minutes of {} {}", amount.minutes, amount.people,
                     amount.people == 1 ? "person" : "people");
}

/// What people's takes give a task.
struct ReadTakes {
  dataset::TrainingData data;
  bool one_person = false;
};

/// Reads the takes, and tells what of them is used.
Result<ReadTakes> read_takes(std::uint64_t seed, std::size_t window, double share, const TaskSource& source,
                             const Progress& progress) {
  MIEN_TRY_ASSIGN(dataset::TakesData takes,
                  dataset::read_training_takes(source.takes, source.splits, source.rig, seed, progress));
  for (const std::string& sentence : takes.left_out) source.tell(sentence);
  const double counted_min = minutes_of(takes.data.train) + minutes_of(takes.data.validation);
  const bool alone = takes.training_people == takes.validation_people;
  ReadTakes out;
  MIEN_TRY_ASSIGN(out.data, as_takes(std::move(takes.data), window));
  const TakesAmount trained = takes_in(out.data.train), held_out = takes_in(out.data.validation);
  out.one_person = alone && held_out.people > 0;
  const double short_min = counted_min - trained.minutes - held_out.minutes;
  if (short_min > 0.05)
    source.tell(fmt::format("{:.1f} minutes are left out: stretches of less than the {} frames of a window",
                            short_min, window));
  source.tell(fmt::format("takes, a share of {:.2g}: {} to train on, {} to validate on", share,
                          amount_text(trained), amount_text(held_out)));
  if (held_out.people == 0 && share < 1)
    source.tell("no take is validated on: the weights are kept that suit virtual performers best");
  return out;
}

/// Of performances that were made before, takes among them or not.
MadeTask make_task_of_file(Recipe recipe, const TaskSource& source) {
  MIEN_TRY_ASSIGN(dataset::TrainingData data, synthetic::read_training_data(source.data));
  const std::vector<std::string> sensors = source.rig.face_sensor_names();
  if (data.train.sensors != sensors)
    return fail(ErrorCode::mismatch,
                fmt::format("the data are of the sensors {}, and the rig has {}",
                            fmt::join(data.train.sensors, ", "), fmt::join(sensors, ", ")),
                source.data.string(), "name the rig that the data were made for");
  return train::make_blendshape_task(std::move(recipe), std::move(data.train), std::move(data.validation),
                                     source.rig_text);
}

/// The recordings that the recipe names, and says what of them is used.
Result<std::vector<face::Motion>> read_recorded(const synthetic::DataRecipe& recipe,
                                                const TaskSource& source) {
  if (recipe.recorded_share == 0) {
    if (source.recorded.empty()) return {};
    return fail(ErrorCode::bad_usage, "the recipe draws nothing from recorded performances", source.where,
                "set data.recorded_share and data.recorded, or leave --recorded away");
  }
  if (source.recorded.empty()) {
    source.tell(
        "without recorded performances: trained on drawn ones alone; name the recordings' folder with "
        "--recorded");
    return {};
  }
  MIEN_TRY_ASSIGN(std::vector<face::Motion> out, synthetic::read_recorded(recipe, source.recorded));
  double seconds = 0;
  for (const face::Motion& motion : out) seconds += motion.duration_s();
  source.tell(fmt::format("recorded performances, a share of {:.2g}: {:.1f} minutes in {} files",
                          recipe.recorded_share, seconds / 60, out.size()));
  return out;
}

MadeTask make_blendshape_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY_ASSIGN(const synthetic::DataRecipe data_recipe,
                  synthetic::parse_data_recipe(recipe.data, source.where));
  if (!source.data.empty()) return make_task_of_file(std::move(recipe), source);
  MIEN_TRY_ASSIGN(const double share, takes_share(recipe, !source.takes.empty(), source.where));
  ReadTakes takes;
  dataset::TrainingData data;
  if (share > 0) {
    recipe.takes_share = share;
    MIEN_TRY_ASSIGN(takes, read_takes(data_recipe.seed, recipe.architecture.window, share, source, progress));
  }
  if (share < 1) {
    MIEN_TRY_ASSIGN(const std::vector<face::Motion> recorded, read_recorded(data_recipe, source));
    if (!recorded.empty()) recipe.recorded = data_recipe.recorded;
    MIEN_TRY_ASSIGN(data,
                    synthetic::make_dataset(data_recipe, source.face, source.rig, progress, 0, recorded));
  }
  if (share == 1) {
    data = std::move(takes.data);
  } else if (share > 0) {
    MIEN_TRY_ASSIGN(data, synthetic::put_together(std::move(data), std::move(takes.data)));
  }
  return train::make_blendshape_task(std::move(recipe), std::move(data.train), std::move(data.validation),
                                     source.rig_text, takes.one_person);
}

Result<void> expect_builtin(const TaskSource& source, std::string what) {
  if (source.face == "builtin") return {};
  return fail(ErrorCode::bad_usage, std::move(what), source.face, "leave --face away");
}

MadeTask make_marker_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY(expect_builtin(source, "virtual wearers of glasses are of the built-in family"));
  MIEN_TRY_ASSIGN(const synthetic::EyewearDataRecipe data_recipe,
                  synthetic::parse_eyewear_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(const std::filesystem::path markers_path, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet markers, builtin_face::read_markers(markers_path));
  MIEN_TRY_ASSIGN(synthetic::EyewearData data,
                  synthetic::make_eyewear_dataset(data_recipe, source.rig, markers, progress));
  return train::make_marker_task(std::move(recipe), std::move(data.train), std::move(data.validation),
                                 source.rig_text);
}

MadeTask make_speech_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY(expect_builtin(source, "who speaks has no face"));
  MIEN_TRY_ASSIGN(const synthetic::SpeechDataRecipe data_recipe,
                  synthetic::parse_speech_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(synthetic::SpeechData data,
                  synthetic::make_speech_dataset(data_recipe, source.speaker, progress));
  return train::make_speech_task(std::move(recipe), std::move(data.train), std::move(data.validation));
}

MadeTask make_headset_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY(expect_builtin(source, "virtual wearers of headsets are of the built-in family"));
  MIEN_TRY_ASSIGN(const synthetic::HeadsetDataRecipe data_recipe,
                  synthetic::parse_headset_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(synthetic::HeadsetFilms films,
                  synthetic::make_headset_films(data_recipe, source.rig, source.films, progress));
  if (recipe.architecture.kind == model::NetworkKind::views)
    return train::make_views_task(std::move(recipe), std::move(films), source.rig, source.rig_text);
  if (source.views.empty())
    return fail(ErrorCode::bad_usage, "a headset's memory learns from what a network of pictures finds",
                source.where,
                "name that model with --views; mien train models/recipes/headset.toml makes one");
  MIEN_TRY_ASSIGN(headset::ViewsFile views, headset::read_views_file(source.views));
  return train::make_memory_task(std::move(recipe), films, std::move(views), source.rig, progress);
}

/// A kind of sensors, and what their network learns.
struct Modality {
  std::string_view kind;  ///< As rigs name it.
  MadeTask (*make)(Recipe recipe, const TaskSource& source, const Progress& progress);
  bool tells_gaze = false;    ///< Its answers have the eyes' directions.
  bool learns_takes = false;  ///< Of people, beside its virtual performers.
};
constexpr std::array kModalities = {
    Modality{.kind = "imu", .make = make_blendshape_task, .learns_takes = true},
    Modality{.kind = "eyewear", .make = make_marker_task},
    Modality{.kind = "speech", .make = make_speech_task},
    Modality{.kind = "camera", .make = make_headset_task, .tells_gaze = true},
};

Result<void> check_takes(const Recipe& recipe, const TaskSource& source, const Modality& modality) {
  if (!source.splits.empty() && source.takes.empty())
    return fail(ErrorCode::bad_usage, "splits say who of the takes is trained on, and no takes are given",
                source.splits.string(), "name their folder with --takes");
  if (!source.data.empty() && !source.takes.empty())
    return fail(ErrorCode::bad_usage, "data that were made before hold all that is trained on",
                source.data.string(), "name either --data or --takes");
  if (!modality.learns_takes && !source.data.empty())
    return fail(
        ErrorCode::bad_usage,
        fmt::format("only IMUs are trained on data that were made before, and these sensors are of the "
                    "kind {}",
                    modality.kind),
        "rig " + source.rig.name, "leave --data away");
  if (!modality.learns_takes && (!source.takes.empty() || recipe.takes_share))
    return fail(
        ErrorCode::bad_usage,
        fmt::format("only IMUs are trained on takes, and these sensors are of the kind {}", modality.kind),
        "rig " + source.rig.name, "leave --takes and the recipe's [takes] away");
  if (!modality.learns_takes && !source.recorded.empty())
    return fail(ErrorCode::bad_usage,
                fmt::format("only wearers of IMUs perform recorded performances, and these sensors are of "
                            "the kind {}",
                            modality.kind),
                "rig " + source.rig.name, "leave --recorded away");
  return {};
}

}  // namespace

Result<std::unique_ptr<Task>> make_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  const std::vector<std::string> kinds = sensor::kinds_of(source.rig);
  if (kinds.size() != 1)
    return fail(ErrorCode::unsupported, "sensors of several kinds are not trained together",
                "rig " + source.rig.name, "train a model for each kind, with a rig of its own");
  const auto modality = std::ranges::find(kModalities, kinds.front(), &Modality::kind);
  if (modality == kModalities.end())
    return fail(ErrorCode::unsupported, "nothing is trained for sensors of the kind " + kinds.front(),
                "rig " + source.rig.name,
                fmt::format("use a rig of the kind {}",
                            fmt::join(kModalities | std::views::transform(&Modality::kind), " or ")));
  if (recipe.gaze_weight != 1 && !modality->tells_gaze)
    return fail(ErrorCode::bad_usage, "what is learnt here tells no directions of eyes", source.where,
                "leave optimiser.gaze_weight away");
  MIEN_TRY(check_takes(recipe, source, *modality));
  return modality->make(std::move(recipe), source, progress);
}

}  // namespace mien::train
