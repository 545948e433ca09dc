#pragma once

#include <memory>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"
#include "mien/train/recipe.h"
#include "mien/train/task.h"

namespace mien::train {

/// What the rig's sensors are to learn, with data made by the recipe's [data]: eyewear learns markers, IMUs
/// learn blendshape weights (make_task.cpp has the table). `where` names the recipe in messages,
/// `face` is study::make_dataset's, `rig_text` goes into the model. Errors: those of data and task;
/// unsupported (sensors of several kinds, or of an unknown one); bad_usage (a face other than the built-in
/// one for photo-reflective sensors).
[[nodiscard]] Result<std::unique_ptr<Task>> make_task(Recipe recipe, const std::string& where,
                                                      const std::string& face, const sensor::Rig& rig,
                                                      std::string rig_text, const Progress& progress);

}  // namespace mien::train
