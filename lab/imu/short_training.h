#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/measure/interval.h"
#include "mien/measure/metrics.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/imu/make_dataset.h"
#include "mien/synthetic/imu/watched_person.h"

namespace mien::lab {

/// The rig as somebody wears it who leaves the other face sensors away: these alone, in the rig's order, with
/// all that are not the face's, and of the `[skin]` table what it says of them (the marginal of a normal
/// distribution). Whoever tells headings by the skin then knows no more than they feel. Errors: not_found (a
/// name that is none of the face's), bad_usage (none is named).
[[nodiscard]] Result<sensor::Rig> rig_with_sensors(const sensor::Rig& rig,
                                                   std::span<const std::string> names);

/// CAPUS's "Fewer IMU" (arXiv:2402.03944v4, Evaluations on Facial Capture): brows, cheeks and jaw, by the
/// names of rigs/default.toml. Which of its two sites of the cheeks it keeps it does not say: here the lower.
inline constexpr std::array<std::string_view, 5> kPaperFive = {
    "frontalis_R", "frontalis_L", "zygomaticus_lower_R", "zygomaticus_lower_L", "mentalis"};

/// The same with the upper site of the cheeks.
inline constexpr std::array<std::string_view, 5> kPaperFiveUpper = {
    "frontalis_R", "frontalis_L", "zygomaticus_upper_R", "zygomaticus_upper_L", "mentalis"};

/// Which network a study trains, all of about as many parameters (0.2 to 0.4 million with eleven sensors).
enum class ShortNetwork : std::uint8_t {
  recurrent,    ///< The live model's kind: two layers of gated recurrent units, 128 wide, frame by frame.
  transformer,  ///< Two layers over a window of 120 frames, which answers at once: no diffusion.
  diffusion,    ///< The same, trained as a denoiser at all noise levels, as CAPUS is; asked in four steps.
};

/// A short training's recipe, but for its data.
struct ShortRecipe {
  std::uint64_t seed = 1;   ///< Of weights, order, augmentation and noise.
  std::size_t steps = 600;  ///< Optimisation steps; each sees 3,840 frames, whatever the window.
  ShortNetwork network = ShortNetwork::recurrent;
  std::size_t window = 120;  ///< Frames that are trained together: a divisor of 3,840.
  /// Recurrent networks' alone: weight of the squared error of changes from frame to frame in the loss.
  /// Higher: smoother, and slower to follow. 0: of the frames alone, as the others are trained.
  double difference_weight = 5;
};

/// A seed as recipes take it: TOML's integers are signed, of 64 bits. So the highest bit is left out; seeds
/// below 2^63 stay as they are.
[[nodiscard]] std::uint64_t recipe_seed(std::uint64_t seed);

/// ShortRecipe::seed of one of a study's trainings, from 0 on: recipe_seed(100 study_seed + training), the
/// sum modulo 2^64. Studies of neighbouring seeds share none while each has at most 100 trainings.
[[nodiscard]] std::uint64_t training_seed(std::uint64_t study_seed, std::size_t training);

/// As TOML, with what the data are.
[[nodiscard]] std::string short_recipe(const ShortRecipe& recipe, const synthetic::DataRecipe& data);

/// Whom short trainings learn from: 300 virtual people for 24 s each in *lab*, and two in five of them in
/// *device* too, as unlike the standard skin as those of the shipped models.
[[nodiscard]] synthetic::DataRecipe short_data(std::uint64_t seed);

/// The `[data]` table of a recipe, without its head.
[[nodiscard]] std::string data_table(const synthetic::DataRecipe& data);

/// A network that a study trains for itself, with a small budget: short enough that a table of them is a
/// matter of an hour, long enough that rows can be told apart.
struct ShortTraining {
  std::string name;    ///< In progress and file names: lower case letters, digits, '-' and '_'.
  std::string recipe;  ///< As TOML (docs/guide/training.md), with its budget in steps.
  std::string rig;     ///< Text of the rig file, which goes into the model.
  /// Names all that `data` depends on: two trainings with one key have the same data.
  std::string data_key;
  /// Asked for when the training is due, and not at all where its model stands already. Not called from two
  /// threads at once.
  std::function<Result<dataset::TrainingData>(const Progress& progress)> data;
};

/// Trains them, or finds them trained: one each, in their order. The same trainings give the same bits,
/// however often it was stopped in between. Given by the program, whose helper knows libtorch. Errors: the
/// data's and the trainer's; cancelled.
using TrainShort = std::function<Result<std::vector<model::ModelFile>>(
    std::span<const ShortTraining> trainings, const Progress& progress)>;

/// What a model's answers to one person are off, over all of the person's frames.
struct PersonErrors {
  double pve_mm = 0;  ///< Mean vertex error.
  double lmk_mm = 0;  ///< Mean error of the 68 landmarks; 0 on a face without them.
  double mse = 0;     ///< Of the 53 weights.
  double jitter = 0;  ///< Third difference of the landmarks over the truth's; 0 where the truth rests.
};

/// Errors of a network that was trained with several seeds: of each seed one figure a person.
struct SeedErrors {
  measure::SeedFigures pve_mm, lmk_mm, mse, jitter;
  [[nodiscard]] bool empty() const { return pve_mm.empty(); }
  /// One more seed's, of the same people in the same order.
  void add_seed(std::span<const PersonErrors> people);
};

/// Each person's errors, in their order. `sensors`: names of the features' entries; those that the model does
/// not know are passed over. `meter`: of the face on which weights become millimetres. Errors: the tracker's;
/// cancelled. The same for any number of threads (0: one a core).
[[nodiscard]] Result<std::vector<PersonErrors>> errors_of_people(
    const model::ModelFile& model, const std::vector<std::string>& sensors,
    std::span<const synthetic::ImuPerson> people, const measure::Meter& meter,
    synthetic::WindowJoin join = synthetic::WindowJoin::overlap, unsigned threads = 0);

/// People of a data set's *lab* profile, with the profile's degree of white noise an axis, from `seed`.
[[nodiscard]] std::vector<synthetic::ImuPerson> watched_in_lab(const dataset::Dataset& data,
                                                               std::uint64_t seed);

}  // namespace mien::lab
