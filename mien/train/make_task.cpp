#include "mien/train/make_task.h"

#include <utility>

#include "mien/core/files.h"
#include "mien/eyewear/light_grid.h"
#include "mien/sensor/rig_part.h"
#include "mien/study/eyewear/eyewear_dataset.h"
#include "mien/study/imu/make_dataset.h"
#include "mien/train/blendshape_task.h"
#include "mien/train/marker_task.h"

namespace mien::train {

Result<std::unique_ptr<Task>> make_task(Recipe recipe, const std::string& where, const std::string& face,
                                        const sensor::Rig& rig, std::string rig_text,
                                        const Progress& progress) {
  const std::string data_place = where + ", [data]";
  if (sensor::kinds_of(rig).size() > 1)
    return fail(ErrorCode::unsupported, "sensors of several kinds are not trained together",
                "rig " + rig.name, "train a model for each kind, with a rig of its own");
  if (eyewear::photo_sensors(rig).size() == rig.sensors.size()) {
    if (face != "builtin")
      return fail(ErrorCode::bad_usage, "virtual wearers of glasses are of the built-in family", face,
                  "leave --face away");
    MIEN_TRY_ASSIGN(const study::EyewearDataRecipe data_recipe,
                    study::parse_eyewear_data_recipe(recipe.data, data_place));
    MIEN_TRY_ASSIGN(const std::filesystem::path markers_path, find_resource("rigs/markers.toml"));
    MIEN_TRY_ASSIGN(const builtin_face::MarkerSet markers, builtin_face::read_markers(markers_path));
    MIEN_TRY_ASSIGN(study::EyewearData data,
                    study::make_eyewear_dataset(data_recipe, rig, markers, progress));
    return MarkerTask::create(std::move(recipe), std::move(data.train), std::move(data.validation),
                              std::move(rig_text));
  }
  MIEN_TRY_ASSIGN(const study::DataRecipe data_recipe, study::parse_data_recipe(recipe.data, data_place));
  MIEN_TRY_ASSIGN(study::TrainingData data, study::make_dataset(data_recipe, face, rig, progress));
  return BlendshapeTask::create(std::move(recipe), std::move(data.train), std::move(data.validation),
                                std::move(rig_text));
}

}  // namespace mien::train
