#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/performer/speaker.h"
#include "mien/sensor/rig.h"
#include "mien/train/recipe.h"
#include "mien/train/task.h"

namespace mien::train {

/// Whose data a task is made of.
struct TaskSource {
  std::string where;            ///< Names the recipe in messages.
  std::string face;             ///< synthetic::make_dataset's.
  sensor::Rig rig;              ///< Whose sensors learn.
  std::string rig_text;         ///< Its file, which goes into the model.
  performer::Speaker speaker;   ///< Who speaks for microphones.
  std::filesystem::path films;  ///< A folder for films of headset cameras: kept, and gone on with.
  std::filesystem::path views;  ///< A network of pictures, for a memory to learn from what it finds.
  /// A folder of people's takes, for IMUs to learn from as the recipe's [takes] says; empty: virtual
  /// performers alone.
  std::filesystem::path takes;
  std::filesystem::path splits;  ///< Who of them is trained and who validated on; empty: drawn.
  /// A file of performances that were made before (synthetic::read_training_data), for IMUs to learn from
  /// instead of what [data] says; empty: they are made.
  std::filesystem::path data;
  /// A folder of recorded performances, for virtual wearers of IMUs to perform as the recipe's [data] says;
  /// empty: drawn performances alone, which `tell` then says.
  std::filesystem::path recorded;
  /// Told of the takes before training begins, a line each: what is left out and why, how much is trained on.
  std::function<void(const std::string& line)> tell = [](const std::string&) {};
};

/// What the rig's sensors are to learn, with data made by the recipe's [data]: IMUs learn blendshape weights,
/// eyewear learns markers, a microphone learns the mouth, cameras learn weights and gaze, and the memory of
/// what they show (make_task.cpp has the table). Errors: those of data and task; unsupported (sensors of
/// several kinds, or of an unknown one); bad_usage (a face other than the built-in one for photo-reflective
/// sensors or for a microphone; takes for others than IMUs, or none where the recipe wants them).
[[nodiscard]] Result<std::unique_ptr<Task>> make_task(Recipe recipe, const TaskSource& source,
                                                      const Progress& progress);

}  // namespace mien::train
