#include "mien/train/make_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ranges>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/files.h"
#include "mien/sensor/rig_part.h"
#include "mien/study/eyewear/eyewear_dataset.h"
#include "mien/study/headset/headset_dataset.h"
#include "mien/study/imu/make_dataset.h"
#include "mien/study/speech/speech_dataset.h"
#include "mien/train/blendshape_task.h"
#include "mien/train/marker_task.h"
#include "mien/train/memory_task.h"
#include "mien/train/speech_task.h"
#include "mien/train/views_task.h"

namespace mien::train {
namespace {

using MadeTask = Result<std::unique_ptr<Task>>;

MadeTask make_blendshape_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY_ASSIGN(const study::DataRecipe data_recipe, study::parse_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(study::TrainingData data,
                  study::make_dataset(data_recipe, source.face, source.rig, progress));
  return BlendshapeTask::create(std::move(recipe), std::move(data.train), std::move(data.validation),
                                source.rig_text);
}

Result<void> expect_builtin(const TaskSource& source, std::string what) {
  if (source.face == "builtin") return {};
  return fail(ErrorCode::bad_usage, std::move(what), source.face, "leave --face away");
}

MadeTask make_marker_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY(expect_builtin(source, "virtual wearers of glasses are of the built-in family"));
  MIEN_TRY_ASSIGN(const study::EyewearDataRecipe data_recipe,
                  study::parse_eyewear_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(const std::filesystem::path markers_path, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet markers, builtin_face::read_markers(markers_path));
  MIEN_TRY_ASSIGN(study::EyewearData data,
                  study::make_eyewear_dataset(data_recipe, source.rig, markers, progress));
  return MarkerTask::create(std::move(recipe), std::move(data.train), std::move(data.validation),
                            source.rig_text);
}

MadeTask make_speech_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY(expect_builtin(source, "who speaks has no face"));
  MIEN_TRY_ASSIGN(const study::SpeechDataRecipe data_recipe,
                  study::parse_speech_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(study::SpeechData data, study::make_speech_dataset(data_recipe, source.speaker, progress));
  return SpeechTask::create(std::move(recipe), std::move(data.train), std::move(data.validation));
}

MadeTask make_headset_task(Recipe recipe, const TaskSource& source, const Progress& progress) {
  MIEN_TRY(expect_builtin(source, "virtual wearers of headsets are of the built-in family"));
  MIEN_TRY_ASSIGN(const study::HeadsetDataRecipe data_recipe,
                  study::parse_headset_data_recipe(recipe.data, source.where));
  MIEN_TRY_ASSIGN(study::HeadsetFilms films,
                  study::make_headset_films(data_recipe, source.rig, source.films, progress));
  if (recipe.architecture.kind == model::NetworkKind::views)
    return ViewsTask::create(std::move(recipe), std::move(films), source.rig, source.rig_text);
  if (source.views.empty())
    return fail(ErrorCode::bad_usage, "a headset's memory learns from what a network of pictures finds",
                source.where,
                "name that model with --views; mien train models/recipes/headset.toml makes one");
  MIEN_TRY_ASSIGN(headset::ViewsFile views, headset::read_views_file(source.views));
  return MemoryTask::create(std::move(recipe), films, std::move(views), source.rig, progress);
}

/// A kind of sensors, and what their network learns.
struct Modality {
  std::string_view kind;  ///< As rigs name it.
  MadeTask (*make)(Recipe recipe, const TaskSource& source, const Progress& progress);
  bool tells_gaze = false;  ///< Its answers have the eyes' directions.
};
constexpr std::array kModalities = {
    Modality{"imu", make_blendshape_task},
    Modality{"eyewear", make_marker_task},
    Modality{"speech", make_speech_task},
    Modality{"camera", make_headset_task, true},
};

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
  return modality->make(std::move(recipe), source, progress);
}

}  // namespace mien::train
